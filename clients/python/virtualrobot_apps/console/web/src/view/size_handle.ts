// Dots at the faces of what the selected node is made of: dragged, a face goes along its normal, and the opposite one stays.
import { clone } from "@bufbuild/protobuf";
import { computed, effect, signal } from "@preact/signals";
import { BufferAttribute, BufferGeometry, CanvasTexture, Color, EdgesGeometry, LineBasicMaterial, LineSegments, Matrix4, Object3D, Points, PointsMaterial, Vector3 } from "three";
import { FigureSchema, type Figure, type Node } from "../generated/virtualrobot/v1/nodes_pb";
import { change } from "../kernel/orders";
import { hearers, items, selected } from "../kernel/world";
import { facesOf, type Face } from "./faces";
import { primitive, seen } from "./figures";
import { tool } from "./gizmo";
import { draggedNode, snaps } from "./node_handle";
import { pointerRay } from "./pointing";
import type { Viewport } from "./viewport";

const RASTER_METERS = 0.01;
const LEAST_METERS = 0.001;
const NEAR_PIXELS = 10;
const DOT_PIXELS = 13;
const ORDER = 945;
const INK = new Color(0xf5a623), LIT = new Color(0xffffff);
/** Nodes of more figures have dots at the first ones. */
const MOST_FIGURES = 12;

interface Dot extends Face {
  /** Place of the figure among those of the node. */
  figure: number;
}

interface Drag {
  dot: Dot;
  node: Node;
  world_t_figure: Matrix4;
  /** Where the pointer took hold, along the face's normal. */
  from: number;
  size: number;
}

/** The node whose faces may be dragged; undefined: none. */
const sized = computed(() => {
  const item = tool.value === "size" ? items.value.get(selected.value) : undefined;
  return item && item.kind !== "world" && item.kind !== "link" && !item.node.locked ? item : undefined;
});

const dots = computed<readonly Dot[]>(() => {
  const item = sized.value;
  if (!item) return [];
  const drawn = new Set(seen(item));
  return item.node.figures.flatMap((figure, place) => (drawn.has(figure) ? facesOf(figure).map((face) => ({ ...face, figure: place })) : [])).slice(0, 6 * MOST_FIGURES);
});

/** Place of the dot that the pointer is at, among all. */
const lit = signal(-1);

export class SizeHandle {
  readonly objects: Object3D[];
  #points = new Points(new BufferGeometry(), new PointsMaterial({ size: DOT_PIXELS, sizeAttenuation: false, map: disc(), transparent: true, depthTest: false, vertexColors: true, toneMapped: false }));
  #rim = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: INK, depthTest: false, transparent: true, toneMapped: false }));
  #drag?: Drag;

  constructor(private readonly view: Viewport, host: HTMLElement) {
    this.objects = [this.#points, this.#rim];
    for (const one of [this.#points, this.#rim]) {
      one.frustumCulled = false;
      one.renderOrder = ORDER;
    }
    this.#rim.matrixAutoUpdate = this.#rim.visible = false;
    // Before the view is turned by the pointer, or clicks select.
    host.addEventListener("pointerdown", (event) => this.#press(event, host), { capture: true });
    host.addEventListener("pointermove", (event) => this.#move(event), { capture: true });
    host.addEventListener("pointerup", () => void this.#release());
    host.addEventListener("pointercancel", () => this.leave());
    hearers.poses.add(() => this.#place());
    effect(() => {
      const all = dots.value;
      this.#points.visible = all.length > 0;
      host.style.cursor = all[lit.value] ? "grab" : "";
      this.#points.geometry.dispose();
      this.#points.geometry = new BufferGeometry();
      this.#points.geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * all.length), 3));
      this.#points.geometry.setAttribute("color", new BufferAttribute(new Float32Array(all.flatMap((_, place) => (place === lit.value ? LIT : INK).toArray())), 3));
      this.#place();
      view.invalidate();
    });
  }

  /** Leaves the node as it is. */
  leave(): void {
    if (!this.#drag) return;
    this.#drag = undefined;
    draggedNode.value = undefined;
    lit.value = -1;
    this.#rim.visible = false;
    this.view.invalidate();
  }

  #place(): void {
    const item = sized.peek(), positions = this.#points.geometry.getAttribute("position");
    const pose = item && this.view.solids.places.get(item.name);
    if (!pose || positions?.count !== dots.peek().length) return;
    dots.peek().forEach(({ at }, place) => positions.setXYZ(place, ...at.clone().applyMatrix4(pose).toArray()));
    positions.needsUpdate = true;
  }

  #press(event: PointerEvent, host: HTMLElement): void {
    const dot = event.button === 0 && !event.altKey && dots.peek()[this.#nearest(event)], item = sized.peek();
    const pose = item && this.view.solids.places.get(item.name);
    if (!dot || !pose) return;
    event.stopPropagation();
    event.preventDefault();
    host.setPointerCapture(event.pointerId);
    const drag = { dot, node: item.node, world_t_figure: pose.clone(), from: 0, size: dot.size };
    this.#drag = { ...drag, from: this.#along(event, drag) ?? 0 };
    this.#show();
  }

  #move(event: PointerEvent): void {
    if (!this.#drag) {
      if (event.buttons !== 0 || dots.peek().length === 0) return;
      lit.value = this.#nearest(event);
      return;
    }
    event.stopPropagation();
    const drag = this.#drag, along = this.#along(event, drag);
    if (along === undefined) return;
    const wanted = drag.dot.size + (along - drag.from) * drag.dot.sizePerMeter;
    drag.size = Math.max(snaps.peek() ? RASTER_METERS : LEAST_METERS, snaps.peek() ? RASTER_METERS * Math.round(wanted / RASTER_METERS) : wanted);
    this.#show();
  }

  /** Tells the kernel how large the figure is now. */
  async #release(): Promise<void> {
    const drag = this.#drag;
    if (!drag) return;
    const { dot, size, node } = drag;
    if (size !== dot.size) await change(node.name, "figures", ({ figures }) => figures[dot.figure] && dot.resize(figures[dot.figure], size));
    if (this.#drag === drag) this.leave();
  }

  /** Draws the edges of the figure as large as it would be, and says how large. */
  #show(): void {
    const { dot, node, size, world_t_figure } = this.#drag!;
    const figure: Figure = clone(FigureSchema, node.figures[dot.figure]);
    dot.resize(figure, size);
    const piece = primitive(figure)!;
    this.#rim.geometry.dispose();
    this.#rim.geometry = new EdgesGeometry(piece.geometry, 20);
    this.#rim.matrix.multiplyMatrices(world_t_figure, piece.local);
    this.#rim.matrixWorldNeedsUpdate = true;
    this.#rim.visible = true;
    draggedNode.value = { name: node.name, position: new Vector3(), size: { name: dot.name, meters: size }, beside: [] };
    this.view.invalidate();
  }

  /** Returns where the ray through the pointer is nearest to the line along which a face goes (m from the face); undefined where it goes along that line. */
  #along(event: PointerEvent, { dot, world_t_figure }: Pick<Drag, "dot" | "world_t_figure">): number | undefined {
    const { origin, direction } = pointerRay(this.view, event).ray;
    const at = dot.at.clone().applyMatrix4(world_t_figure), normal = dot.normal.clone().transformDirection(world_t_figure);
    const slant = normal.dot(direction), between = origin.clone().sub(at);
    if (1 - slant * slant < 1e-3) return undefined;
    return (between.dot(normal) - slant * between.dot(direction)) / (1 - slant * slant);
  }

  /** Returns the place of the dot that is nearest to the pointer; -1 where none is near. */
  #nearest({ clientX, clientY }: PointerEvent): number {
    const positions = this.#points.geometry.getAttribute("position"), area = this.view.canvas.getBoundingClientRect();
    const distances = dots.peek().map((_, place) => {
      const seen = new Vector3().fromBufferAttribute(positions, place).project(this.view.observer.camera);
      return Math.hypot(area.left + (area.width * (1 + seen.x)) / 2 - clientX, area.top + (area.height * (1 - seen.y)) / 2 - clientY);
    });
    const least = Math.min(...distances);
    return least < NEAR_PIXELS ? distances.indexOf(least) : -1;
  }
}

/** Returns the picture of a dot: a disc with a dark rim. */
function disc(): CanvasTexture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext("2d")!;
  pen.arc(32, 32, 26, 0, 2 * Math.PI);
  pen.fillStyle = "#fff";
  pen.fill();
  pen.lineWidth = 9;
  pen.strokeStyle = "#15191f";
  pen.stroke();
  return new CanvasTexture(canvas);
}
