// Bulk numbers of the contract.
import { NumericType, type NumericArray } from "../generated/virtualrobot/v1/geometry_pb";

/** Returns the numbers of an array as doubles; they are copied, since they begin anywhere in the message. */
export function ofArray({ type, data }: NumericArray): Float64Array {
  const bytes = data.slice().buffer;
  if (type === NumericType.FLOAT32) return Float64Array.from(new Float32Array(bytes));
  if (type === NumericType.INT32) return Float64Array.from(new Int32Array(bytes));
  if (type === NumericType.UINT8) return Float64Array.from(new Uint8Array(bytes));
  return new Float64Array(bytes);
}

/** Returns rows of so many numbers each. */
export function rowsOf(numbers: Float64Array, width: number): number[][] {
  return Array.from({ length: numbers.length / width }, (_, row) => [...numbers.subarray(row * width, (row + 1) * width)]);
}
