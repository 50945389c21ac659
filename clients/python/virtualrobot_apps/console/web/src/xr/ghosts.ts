// A robot at several moments of its way at once, in one drawing however many figures and moments there are.
import { BatchedMesh, BufferGeometry, Float32BufferAttribute, Group, Matrix4, MeshStandardMaterial, type BufferAttribute, type InterleavedBufferAttribute } from "three";
import type { Piece } from "../view/figures";

type Places = ReadonlyMap<string, Matrix4>;

interface Copy {
  node: string;
  local: Matrix4;
  /** Its number in the drawing, for each moment. */
  numbers: number[];
}

export class Ghosts {
  readonly group = new Group();
  #material = new MeshStandardMaterial({ transparent: true, roughness: 0.5 });
  #mesh?: BatchedMesh;
  #copies: Copy[] = [];
  #moments: readonly Places[] = [];

  /** `most` moments can be shown at once. */
  constructor(private readonly most: number) {}

  /** Makes copies of what these nodes look like. */
  rebuild(nodes: readonly string[], pieces: ReadonlyMap<string, readonly Piece[]>): void {
    const all = nodes.flatMap((node) => (pieces.get(node) ?? []).map(({ geometry, local }) => ({ node, local, geometry })));
    const bare = new Map([...new Set(all.map(({ geometry }) => geometry))].map((one) => [one, bared(one)]));
    const sum = (count: (one: BufferGeometry) => number) => [...bare.values()].reduce((before, one) => before + count(one), 0);
    this.#mesh?.dispose();
    this.group.clear();
    this.#copies = [];
    this.#mesh = undefined;
    if (all.length === 0) return;
    const mesh = new BatchedMesh(this.most * all.length, sum((one) => one.getAttribute("position").count), sum((one) => one.index!.count), this.#material);
    mesh.frustumCulled = mesh.perObjectFrustumCulled = mesh.sortObjects = false;
    mesh.renderOrder = 800;
    const shapes = new Map([...bare].map(([geometry, one]) => [geometry, mesh.addGeometry(one)]));
    this.#copies = all.map(({ node, local, geometry }) => ({
      node,
      local,
      numbers: Array.from({ length: this.most }, () => mesh.addInstance(shapes.get(geometry)!)),
    }));
    this.#mesh = mesh;
    this.group.add(mesh);
    this.show(this.#moments);
  }

  /** Shows the nodes where they are in the world at these moments, and no others. */
  show(moments: readonly Places[]): void {
    this.#moments = moments;
    this.#material.opacity = moments.length > 1 ? 0.2 : 0.45;
    this.group.visible = moments.length > 0;
    const matrix = new Matrix4();
    for (const { node, local, numbers } of this.#copies) {
      numbers.forEach((number, place) => {
        const pose = moments[place]?.get(node);
        this.#mesh!.setVisibleAt(number, pose !== undefined);
        if (pose) this.#mesh!.setMatrixAt(number, matrix.multiplyMatrices(pose, local));
      });
    }
  }

  tint(color: number): void {
    this.#material.color.set(color);
  }
}

/** Returns triangles with their normals alone, so that all of them go into one drawing. */
function bared(geometry: BufferGeometry): BufferGeometry {
  const { index } = geometry, position = geometry.getAttribute("position");
  const bare = new BufferGeometry().setAttribute("position", numbersOf(position));
  bare.setIndex(index ? [...index.array] : [...Array(position.count).keys()]);
  const normal = geometry.getAttribute("normal");
  if (normal) bare.setAttribute("normal", numbersOf(normal));
  else bare.computeVertexNormals();
  return bare;
}

function numbersOf(attribute: BufferAttribute | InterleavedBufferAttribute): Float32BufferAttribute {
  const numbers = Array.from({ length: 3 * attribute.count }, (_, at) => attribute.getComponent(Math.floor(at / 3), at % 3));
  return new Float32BufferAttribute(numbers, 3);
}
