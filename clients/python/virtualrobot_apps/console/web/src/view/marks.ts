// What has no surface: points, lines, frames, labels, and the axes of targets.
import * as THREE from "three";
import type { Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { ofArray } from "../kernel/arrays";
import type { Item } from "../kernel/world";
import { seen } from "./figures";
import { matrixOf } from "./poses";

const INK = 0x4b9dff;
const FRAME_METERS = 0.1;
const TARGET_METERS = 0.08;
const LABEL_PIXELS = 44;
const LABEL_METERS = 0.05;

export class Marks {
  readonly group = new THREE.Group();

  rebuild(items: Iterable<Item>): void {
    this.group.clear();
    for (const item of items) {
      for (const figure of seen(item)) {
        const object = mark(figure);
        if (object) this.#add(object, item.name, matrixOf(figure.nodeTFigure));
      }
      if (item.kind === "target") this.#add(new THREE.AxesHelper(TARGET_METERS), item.name, new THREE.Matrix4());
    }
  }

  place(world: ReadonlyMap<string, THREE.Matrix4>): void {
    for (const object of this.group.children) {
      const pose = world.get(object.userData.node as string);
      if (!pose) continue;
      object.matrix.multiplyMatrices(pose, object.userData.local as THREE.Matrix4);
      object.matrixWorldNeedsUpdate = true;
    }
  }

  #add(object: THREE.Object3D, node: string, local: THREE.Matrix4): void {
    const holder = new THREE.Group();
    holder.matrixAutoUpdate = false;
    holder.userData = { node, local };
    holder.add(object);
    this.group.add(holder);
  }
}

function mark({ geometry, material }: Figure): THREE.Object3D | undefined {
  const said = material?.color;
  const color = said ? new THREE.Color().setRGB(said.red, said.green, said.blue, "srgb") : new THREE.Color(INK);
  switch (geometry.case) {
    case "points":
      return points(geometry.value, color);
    case "lines":
      return geometry.value.segments && new THREE.LineSegments(line(ofArray(geometry.value.segments)), new THREE.LineBasicMaterial({ color }));
    case "frame":
      return new THREE.AxesHelper(geometry.value.lengthMeters || FRAME_METERS);
    case "label":
      return label(geometry.value.text);
    default:
      return undefined;
  }
}

function line(numbers: Float64Array): THREE.BufferGeometry {
  return new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(Float32Array.from(numbers), 3));
}

function points({ positions, colors, sizeMeters }: Extract<Figure["geometry"], { case: "points" }>["value"], color: THREE.Color) {
  if (!positions) return undefined;
  const geometry = line(ofArray(positions));
  const material = new THREE.PointsMaterial({ color, size: sizeMeters || 0.01 });
  if (colors && colors.data.length > 0) {
    geometry.setAttribute("color", new THREE.BufferAttribute(colors.data.slice(), 3, true));
    material.vertexColors = true;
    material.color.set(0xffffff);
  }
  return new THREE.Points(geometry, material);
}

function label(text: string): THREE.Sprite {
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d")!;
  const font = `600 ${LABEL_PIXELS * 0.6}px "Inter Variable", sans-serif`;
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + LABEL_PIXELS * 0.6;
  canvas.height = LABEL_PIXELS;
  pen.font = font;
  pen.fillStyle = "rgba(21, 25, 31, 0.82)";
  pen.roundRect(0, 0, canvas.width, canvas.height, 12);
  pen.fill();
  pen.fillStyle = "#e4e9ef";
  pen.textBaseline = "middle";
  pen.fillText(text, LABEL_PIXELS * 0.3, LABEL_PIXELS / 2);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false }));
  sprite.scale.set((LABEL_METERS * canvas.width) / canvas.height, LABEL_METERS, 1);
  sprite.renderOrder = 950;
  return sprite;
}
