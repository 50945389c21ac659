/** Bulk numbers of the contract. */

import { type NumericArray, NumericType } from "./generated/virtualrobot/v1/geometry_pb.js";

/** Returns the numbers of a float64 array in C order; throws when it is another one. */
export function float64s(array: NumericArray): Float64Array {
  if (array.type !== NumericType.FLOAT64) throw new Error(`expected an array of float64, not ${NumericType[array.type]}`);
  const { buffer, byteOffset, byteLength } = array.data;
  // Number by number, since a Float64Array begins at multiples of 8 bytes, and `data` lies anywhere in its message.
  const view = new DataView(buffer, byteOffset, byteLength);
  return Float64Array.from({ length: byteLength / 8 }, (_, index) => view.getFloat64(8 * index, true));
}

/** Returns the numbers of a float32 array in C order; throws when it is another one. */
export function float32s(array: NumericArray): Float32Array {
  if (array.type !== NumericType.FLOAT32) throw new Error(`expected an array of float32, not ${NumericType[array.type]}`);
  const { buffer, byteOffset, byteLength } = array.data;
  const view = new DataView(buffer, byteOffset, byteLength);
  return Float32Array.from({ length: byteLength / 4 }, (_, index) => view.getFloat32(4 * index, true));
}
