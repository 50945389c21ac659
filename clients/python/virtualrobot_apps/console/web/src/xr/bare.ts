// Geometries with only those numbers that a drawing of many of them needs: all in one have to have the same.
import { BufferGeometry, Float32BufferAttribute, type BufferAttribute, type InterleavedBufferAttribute } from "three";

export type Numbers = "position" | "normal" | "uv" | "color";

const SIZES: Record<Numbers, number> = { position: 3, normal: 3, uv: 2, color: 3 };

/** Returns triangles by index, with these numbers of each corner; normals are made where there are none, others are 0 then, and colors white. */
export function bared(geometry: BufferGeometry, wanted: readonly Numbers[]): BufferGeometry {
  const { index } = geometry, { count } = geometry.getAttribute("position");
  const bare = new BufferGeometry().setIndex(index ? [...index.array] : [...Array(count).keys()]);
  for (const name of wanted) {
    const given = geometry.getAttribute(name) as BufferAttribute | InterleavedBufferAttribute | undefined;
    if (given || name !== "normal") bare.setAttribute(name, numbersOf(given, name, count));
  }
  if (wanted.includes("normal") && !geometry.getAttribute("normal")) bare.computeVertexNormals();
  return bare;
}

function numbersOf(given: BufferAttribute | InterleavedBufferAttribute | undefined, name: Numbers, count: number): Float32BufferAttribute {
  const size = SIZES[name], numbers = new Float32Array(size * count).fill(name === "color" ? 1 : 0);
  if (given) for (let at = 0; at < numbers.length; at++) numbers[at] = given.getComponent(Math.floor(at / size), at % size);
  return new Float32BufferAttribute(numbers, size);
}

/** Returns how many corners, and places in their indices, geometries have together. */
export function sizeOf(all: Iterable<BufferGeometry>): [corners: number, indices: number] {
  let corners = 0, indices = 0;
  for (const one of all) {
    corners += one.getAttribute("position").count;
    indices += one.index!.count;
  }
  return [corners, indices];
}
