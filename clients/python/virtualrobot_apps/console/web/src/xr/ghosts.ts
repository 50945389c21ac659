// A robot at several moments of its way at once, in one drawing however many figures and moments there are.
import { BatchedMesh, Group, Matrix4, MeshStandardMaterial, type ColorRepresentation } from "three";
import type { Piece } from "../view/figures";
import { bared, sizeOf } from "./bare";

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

  /** `most` moments can be shown at once; without an opacity many at once are more translucent than one. */
  constructor(private readonly most: number, private readonly opacity?: number) {}

  /** Makes copies of what these nodes look like. */
  rebuild(nodes: readonly string[], pieces: ReadonlyMap<string, readonly Piece[]>): void {
    const all = nodes.flatMap((node) => (pieces.get(node) ?? []).map(({ geometry, local }) => ({ node, local, geometry })));
    const bare = new Map([...new Set(all.map(({ geometry }) => geometry))].map((one) => [one, bared(one, ["position", "normal"])]));
    this.#mesh?.dispose();
    this.group.clear();
    this.#copies = [];
    this.#mesh = undefined;
    if (all.length === 0) return;
    const mesh = new BatchedMesh(this.most * all.length, ...sizeOf(bare.values()), this.#material);
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
    this.#material.opacity = this.opacity ?? (moments.length > 1 ? 0.2 : 0.45);
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

  tint(color: ColorRepresentation): void {
    this.#material.color.set(color);
  }
}
