/** Bulk numbers of the contract. */

import { ArrayType } from "./generated/virtualrobot/v1/geometry_pb.js";
import type { Array as NumberArray } from "./generated/virtualrobot/v1/geometry_pb.js"; // would hide JavaScript's Array

/** Returns the numbers of a float64 array in C order; throws when it is another one. */
export function float64s(array: NumberArray): Float64Array {
  if (array.type !== ArrayType.FLOAT64) throw new Error(`expected an array of float64, not ${ArrayType[array.type]}`);
  const { buffer, byteOffset, byteLength } = array.data;
  // Number by number, since a Float64Array begins at multiples of 8 bytes, and `data` lies anywhere in its message.
  const view = new DataView(buffer, byteOffset, byteLength);
  return Float64Array.from({ length: byteLength / 8 }, (_, index) => view.getFloat64(8 * index, true));
}
