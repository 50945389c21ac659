// All pieces of the world in as few drawings as there are pairs of geometry and material.
import { Color, DynamicDrawUsage, Group, InstancedMesh, Matrix4, type BufferGeometry, type Intersection, type Raycaster } from "three";
import type { Piece } from "./figures";

interface Batch {
  mesh: InstancedMesh;
  nodes: string[];
  locals: Matrix4[];
}

interface Gathered {
  piece: Piece;
  nodes: string[];
  locals: Matrix4[];
  colors: (Color | undefined)[];
}

/** What a ray has met: a node, its geometry there, and that one's pose in the node's frame. */
export interface Hit {
  name: string;
  geometry: BufferGeometry;
  local: Matrix4;
  hit: Intersection;
}

const WHITE = new Color(1, 1, 1);

export class Batches {
  readonly group = new Group();
  #batches: Batch[] = [];

  /** Draws these pieces in place of those before. */
  rebuild(pieces: ReadonlyMap<string, readonly Piece[]>): void {
    for (const { mesh } of this.#batches) mesh.dispose();
    this.group.clear();
    this.#batches = [...gathered(pieces).values()].map((one) => this.#batch(one));
  }

  /** Puts everything where its node is. */
  place(world: ReadonlyMap<string, Matrix4>): void {
    const matrix = new Matrix4();
    for (const { mesh, nodes, locals } of this.#batches) {
      nodes.forEach((name, instance) => {
        const pose = world.get(name);
        if (pose) mesh.setMatrixAt(instance, matrix.multiplyMatrices(pose, locals[instance]));
      });
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
    }
  }

  /** Returns what a ray meets first, and where. */
  hit(ray: Raycaster): Hit | undefined {
    const [hit] = ray.intersectObjects(this.group.children, false);
    const batch = this.#batches.find(({ mesh }) => mesh === hit?.object);
    return batch && { name: batch.nodes[hit.instanceId!], geometry: batch.mesh.geometry, local: batch.locals[hit.instanceId!], hit };
  }

  #batch({ piece, nodes, locals, colors }: Gathered): Batch {
    const mesh = new InstancedMesh(piece.geometry, piece.material, nodes.length);
    mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    mesh.castShadow = piece.opaque;
    mesh.receiveShadow = true;
    mesh.frustumCulled = false;
    if (colors.some(Boolean)) colors.forEach((color, instance) => mesh.setColorAt(instance, color ?? WHITE));
    this.group.add(mesh);
    return { mesh, nodes, locals };
  }
}

function gathered(pieces: ReadonlyMap<string, readonly Piece[]>): Map<string, Gathered> {
  const found = new Map<string, Gathered>();
  for (const [name, list] of pieces) {
    for (const piece of list) {
      const key = `${piece.geometry.uuid} ${piece.material.uuid}`;
      let one = found.get(key);
      if (one === undefined) found.set(key, (one = { piece, nodes: [], locals: [], colors: [] }));
      one.nodes.push(name);
      one.locals.push(piece.local);
      one.colors.push(piece.color);
    }
  }
  return found;
}
