// Figures as pieces that are drawn: primitives here, meshes from the kernel's glTF.
import { BoxGeometry, CapsuleGeometry, Color, ConeGeometry, CylinderGeometry, SphereGeometry, Vector3 } from "three";
import { MeshStandardMaterial, type BufferGeometry, type Matrix4 } from "three";
import { FigureRole, type Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { robotOf, states, type Item } from "../kernel/world";
import { matrixOf } from "./poses";

/** A geometry in a material, in the frame of its node; instances of the same two are drawn at once. */
export interface Piece {
  geometry: BufferGeometry;
  material: MeshStandardMaterial;
  local: Matrix4;
  color?: Color;
  opaque: boolean;
}

const GREY = new Color(0xb4bac2);
const OPAQUE = 0.98;
/** What the contract takes where a material tells none. */
export const ROUGHNESS = 0.62;

const UNIT = {
  box: new BoxGeometry(1, 1, 1),
  sphere: new SphereGeometry(1, 32, 20),
  cylinder: new CylinderGeometry(1, 1, 1, 40).rotateX(Math.PI / 2),
  cone: new ConeGeometry(1, 1, 40).rotateX(Math.PI / 2),
};
const capsules = new Map<string, BufferGeometry>();
const plain = new Map<string, MeshStandardMaterial>();

/** Returns the visual figures of a node that its tool's state shows, in the order by which the kernel numbers them. */
export function seen(item: Item): Figure[] {
  const state = toolState(item);
  return item.node.figures.filter(
    ({ roles, toolState }) => (roles.length === 0 || roles.includes(FigureRole.VISUAL)) && (!toolState || toolState === state),
  );
}

function toolState(item: Item): string {
  if (!item.node.figures.some((figure) => figure.toolState)) return "";
  const robot = states.peek().get(robotOf(item.name));
  return robot?.toolStates[item.name] ?? "";
}

/** Returns a name for what a mesh looks like: figures of the same content are drawn with the same triangles. */
export function contentOf(figure: Figure): string {
  if (figure.geometry.case !== "mesh") return "";
  const { sha256, uri, scale, files } = figure.geometry.value;
  const color = figure.material?.color;
  const look = [...(color ? [color.red, color.green, color.blue, color.alpha ?? 1] : []), ...finishOf(figure)];
  return JSON.stringify([sha256 || uri, scale ? [scale.x, scale.y, scale.z] : [], files.map((file) => file.sha256), look]);
}

/** Returns roughness and metalness of a figure's surface. */
function finishOf({ material }: Figure): [roughness: number, metalness: number] {
  return [material?.roughness ?? ROUGHNESS, material?.metalness ?? 0];
}

/** Returns the piece of a primitive; undefined for meshes, and for what has no surface. */
export function primitive(figure: Figure): Piece | undefined {
  const { case: kind, value } = figure.geometry;
  switch (kind) {
    case "box":
      return piece(figure, UNIT.box, value.size?.x ?? 0, value.size?.y ?? 0, value.size?.z ?? 0);
    case "sphere":
      return piece(figure, UNIT.sphere, value.radiusMeters, value.radiusMeters, value.radiusMeters);
    case "cylinder":
      return piece(figure, UNIT.cylinder, value.radiusMeters, value.radiusMeters, value.lengthMeters);
    case "cone":
      return piece(figure, UNIT.cone, value.radiusMeters, value.radiusMeters, value.lengthMeters);
    case "capsule":
      return piece(figure, capsule(value.radiusMeters, value.lengthMeters), 1, 1, 1);
    default:
      return undefined;
  }
}

function piece(figure: Figure, geometry: BufferGeometry, x: number, y: number, z: number): Piece {
  const said = figure.material?.color;
  const alpha = said?.alpha ?? 1;
  const color = said ? new Color().setRGB(said.red, said.green, said.blue, "srgb") : GREY;
  const local = matrixOf(figure.nodeTFigure).scale(new Vector3(x, y, z));
  return { geometry, material: surface(alpha, ...finishOf(figure)), local, color, opaque: alpha >= OPAQUE };
}

function capsule(radius: number, length: number): BufferGeometry {
  const key = `${radius} ${length}`;
  if (!capsules.has(key)) capsules.set(key, new CapsuleGeometry(radius, length, 12, 32).rotateX(Math.PI / 2));
  return capsules.get(key)!;
}

function surface(alpha: number, roughness: number, metalness: number): MeshStandardMaterial {
  const key = [alpha, roughness, metalness].map((value) => value.toFixed(2)).join(" ");
  let material = plain.get(key);
  if (material === undefined) {
    const transparent = alpha < OPAQUE;
    material = new MeshStandardMaterial({ roughness, metalness, transparent, opacity: alpha, depthWrite: !transparent });
    plain.set(key, material);
  }
  return material;
}
