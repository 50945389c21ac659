// The cell as a headset draws it: all that has one look in one drawing, whatever shapes and colors there are, since each
// drawing costs a headset more than its triangles do.
import { BatchedMesh, Color, Group, Matrix4, type BufferGeometry, type MeshStandardMaterial } from "three";
import { hearers } from "../kernel/world";
import type { Piece } from "../view/figures";
import type { Solids } from "../view/solids";
import { bared, sizeOf, type Numbers } from "./bare";

interface Placed {
  mesh: BatchedMesh;
  number: number;
  node: string;
  local: Matrix4;
}

type Instance = Piece & { node: string };

const WHITE = new Color(1, 1, 1);

export class DrawnCell {
  readonly group = new Group();
  #meshes: { mesh: BatchedMesh; material: MeshStandardMaterial }[] = [];
  #placed: Placed[] = [];
  #moved = true;
  readonly #hear = () => void (this.#moved = true);

  constructor(private readonly solids: Solids) {
    hearers.poses.add(this.#hear);
    this.rebuild();
  }

  /** Makes drawings of what there is now. */
  rebuild(): void {
    this.#clear();
    const looks = new Map<string, Instance[]>();
    for (const [node, pieces] of this.solids.pieces) {
      for (const piece of pieces) {
        const look = lookOf(piece.material);
        if (!looks.has(look)) looks.set(look, []);
        looks.get(look)!.push({ ...piece, node });
      }
    }
    for (const instances of looks.values()) this.#draw(instances);
    this.#moved = true;
  }

  /** Puts everything where it is. */
  advance(): void {
    if (!this.#moved) return;
    this.#moved = false;
    const matrix = new Matrix4();
    for (const { mesh, number, node, local } of this.#placed) {
      const pose = this.solids.places.get(node);
      if (pose) mesh.setMatrixAt(number, matrix.multiplyMatrices(pose, local));
    }
  }

  dispose(): void {
    hearers.poses.delete(this.#hear);
    this.#clear();
  }

  #draw(instances: readonly Instance[]): void {
    const [{ material: first }] = instances;
    const wanted: Numbers[] = ["position", "normal", ...(isTextured(first) ? ["uv" as const] : []), ...(first.vertexColors ? ["color" as const] : [])];
    const bare = new Map<BufferGeometry, BufferGeometry>();
    for (const { geometry } of instances) if (!bare.has(geometry)) bare.set(geometry, bared(geometry, wanted));
    // The color is each one's own.
    const material = first.clone();
    material.color.copy(WHITE);
    const mesh = new BatchedMesh(instances.length, ...sizeOf(bare.values()), material);
    mesh.frustumCulled = mesh.perObjectFrustumCulled = mesh.sortObjects = false;
    const shapes = new Map([...bare].map(([geometry, one]) => [geometry, mesh.addGeometry(one)]));
    for (const { geometry, node, local, material: own, color = WHITE } of instances) {
      const number = mesh.addInstance(shapes.get(geometry)!);
      mesh.setColorAt(number, own.color.clone().multiply(color));
      this.#placed.push({ mesh, number, node, local });
    }
    this.#meshes.push({ mesh, material });
    this.group.add(mesh);
  }

  #clear(): void {
    for (const { mesh, material } of this.#meshes) {
      mesh.dispose();
      material.dispose();
    }
    this.group.clear();
    this.#meshes = [];
    this.#placed = [];
  }
}

function isTextured({ map, normalMap, roughnessMap, metalnessMap, emissiveMap, aoMap }: MeshStandardMaterial): boolean {
  return [map, normalMap, roughnessMap, metalnessMap, emissiveMap, aoMap].some((one) => one !== null);
}

/** Returns a name for how a material looks but for its color; one with pictures looks as no other does. */
function lookOf(material: MeshStandardMaterial): string {
  if (isTextured(material)) return material.uuid;
  const { roughness, metalness, opacity, transparent, depthWrite, side, vertexColors, flatShading, emissive, emissiveIntensity } = material;
  const glow = emissive.getHex() ? [emissive.getHex(), emissiveIntensity] : [];
  return JSON.stringify([roughness.toFixed(1), metalness.toFixed(1), transparent ? opacity : 1, depthWrite, side, vertexColors, flatShading, glow]);
}
