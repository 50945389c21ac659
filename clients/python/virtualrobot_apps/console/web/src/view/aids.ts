// What the picture of all viewers has beside the cell: axes of joints, boxes around nodes, and distances, also the least ones, with their
// lengths; in the room as well. The kernel keeps which ones, for its viewer, pictures and every page.
import { effect, signal } from "@preact/signals";
import { Box3, CanvasTexture, Matrix4, Sprite, SpriteMaterial, SRGBColorSpace, Vector3 } from "three";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import type { Measurement } from "../generated/virtualrobot/v1/view_pb";
import { nearest } from "../kernel/clearances";
import { picture } from "../kernel/shared_picture";
import { below, items, moves } from "../kernel/world";
import { fixed } from "../parts/numbers";
import { showSpans, type Span } from "./spans";
import type { Viewport } from "./viewport";

const OWNER = "aids", AXIS = "#c58bff", BOX = "#4cc38a", DISTANCE = "#ffd65c", CLEARANCE = "#3fb6d9";
/** Joints that have an axis, and how far (m) it is drawn to each side. */
const MOVING: ReadonlySet<JointType> = new Set([JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC]);
const AXIS_METERS = 0.15;
/** Corners of a box whose numbers differ in one digit are joined. */
const EDGES = [...Array(8).keys()].flatMap((corner) => [1, 2, 4].filter((bit) => !(corner & bit)).map((bit) => [corner, corner | bit] as const));
const LABEL = { pixels: [256, 64], meters: [0.2, 0.05] } as const;

/** Draws all of it into a view from now on; what it returns is to be called when figures have come or gone. */
export function drawAids(view: Viewport): () => void {
  const labels = new Map<string, Label>(), figures = signal(0);
  let isAny = false;
  effect(() => {
    void [moves.value, figures.value];
    const now = picture.value, wasAny = isAny;
    isAny = now !== undefined && now.jointAxes.length + now.boundingBoxes.length + now.measurements.length + nearest.value.length > 0;
    if (!isAny && !wasAny) return;
    const distances = [
      ...(now?.measurements ?? []).flatMap((one) => distanceOf(view, one)),
      ...nearest.value.map(({ name, from, to, meters }) => ({ name: `clearance ${name}`, span: { from, to, color: CLEARANCE }, meters })),
    ];
    showSpans(OWNER, [
      ...(now?.jointAxes ?? []).flatMap((robot) => axesOf(view, robot)),
      ...(now?.boundingBoxes ?? []).flatMap((node) => boxOf(view, node)),
      ...distances.map(({ span }) => span),
    ]);
    for (const [name, label] of labels) {
      if (distances.some((one) => one.name === name)) continue;
      label.dispose();
      labels.delete(name);
    }
    for (const { name, span, meters } of distances) {
      if (!labels.has(name)) labels.set(name, new Label(view));
      const from = new Vector3().copy(span.from as Vector3), to = new Vector3().copy(span.to as Vector3);
      labels.get(name)!.show(`${fixed(1000 * (meters ?? from.distanceTo(to)), 0)} mm`, from.lerp(to, 0.5));
    }
  });
  return () => void figures.value++;
}

function axesOf(view: Viewport, robot: string): Span[] {
  return below(robot).flatMap((name) => {
    const { kind } = items.peek().get(name)?.node ?? {}, place = view.solids.places.get(name);
    const joint = kind?.case === "link" ? kind.value.joint : undefined;
    if (!place || !joint?.axis || !MOVING.has(joint.type)) return [];
    const { x, y, z } = joint.axis, [from, to] = [-AXIS_METERS, AXIS_METERS].map((far) => new Vector3(x, y, z).multiplyScalar(far).applyMatrix4(place));
    return [{ from, to, color: AXIS }];
  });
}

/** Returns the edges of the box around a node and all below it, in the node's frame. */
function boxOf(view: Viewport, node: string): Span[] {
  const place = view.solids.places.get(node), box = new Box3();
  if (!place) return [];
  const node_t_world = place.clone().invert();
  for (const name of below(node)) {
    const there = view.solids.places.get(name);
    for (const { geometry, local } of (there && view.solids.pieces.get(name)) || []) {
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      box.union(geometry.boundingBox!.clone().applyMatrix4(new Matrix4().multiplyMatrices(node_t_world, there!).multiply(local)));
    }
  }
  if (box.isEmpty()) return [];
  const { min, max } = box;
  const corners = Array.from({ length: 8 }, (_, at) => new Vector3(at & 1 ? max.x : min.x, at & 2 ? max.y : min.y, at & 4 ? max.z : min.z).applyMatrix4(place));
  return EDGES.map(([from, to]) => ({ from: corners[from], to: corners[to], color: BOX }));
}

function distanceOf(view: Viewport, { name, first, second }: Measurement): { name: string; span: Span; meters?: number }[] {
  const [from, to] = [first, second].map((one) => {
    const place = one?.node && one.node !== "world" ? view.solids.places.get(one.node) : new Matrix4(), { x = 0, y = 0, z = 0 } = one?.point ?? {};
    return place && new Vector3(x, y, z).applyMatrix4(place);
  });
  return from && to ? [{ name, span: { from, to, color: DISTANCE } }] : [];
}

/** A length in words, which faces whoever looks. */
class Label {
  #canvas = document.createElement("canvas");
  #texture = new CanvasTexture(this.#canvas);
  #sprite: Sprite;
  #words = "";

  constructor(private readonly view: Viewport) {
    [this.#canvas.width, this.#canvas.height] = LABEL.pixels;
    this.#texture.colorSpace = SRGBColorSpace;
    this.#sprite = new Sprite(new SpriteMaterial({ map: this.#texture, depthTest: false, toneMapped: false }));
    this.#sprite.scale.set(...LABEL.meters, 1);
    this.#sprite.renderOrder = 945;
    view.overlay.add(this.#sprite);
  }

  show(words: string, place: Vector3): void {
    this.#sprite.position.copy(place);
    if (words === this.#words) return;
    this.#words = words;
    const pen = this.#canvas.getContext("2d")!, [width, height] = LABEL.pixels;
    pen.clearRect(0, 0, width, height);
    pen.font = "600 40px Inter Variable, sans-serif";
    pen.textAlign = "center";
    pen.lineWidth = 8;
    pen.strokeStyle = "#15191f";
    pen.fillStyle = DISTANCE;
    pen.strokeText(words, width / 2, 46);
    pen.fillText(words, width / 2, 46);
    this.#texture.needsUpdate = true;
  }

  dispose(): void {
    this.view.overlay.remove(this.#sprite);
    this.#sprite.material.dispose();
    this.#texture.dispose();
  }
}
