// Faces of simple figures: where they are, and what a figure is when one of them has been drawn out.
import { create } from "@bufbuild/protobuf";
import { Matrix4, Vector3 } from "three";
import { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import type { Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { matrixOf, poseOf } from "./poses";

/** A face, or the side of what is round, in the frame of the figure's node. */
export interface Face {
  /** What the size is called: X, Y or Z, or Ø for a diameter. */
  name: string;
  at: Vector3;
  normal: Vector3;
  /** The size that it bounds, meters, and how much that grows for each meter along the normal. */
  size: number;
  sizePerMeter: number;
  /** Makes a figure as large (m): of a length the opposite face stays where it is, of a diameter the axis. */
  resize(figure: Figure, meters: number): void;
}

const AXES = ["x", "y", "z"] as const;
const SIGNS = [1, -1] as const;

/** Returns the faces of a box, cylinder, cone, capsule or sphere; none of other figures. */
export function facesOf(figure: Figure): Face[] {
  const { case: kind, value } = figure.geometry;
  const node_t_figure = matrixOf(figure.nodeTFigure);
  const face = (name: string, axis: number, sign: number, at: Vector3, size: number, set: (figure: Figure, meters: number) => void): Face => {
    const normal = new Vector3().setComponent(axis, sign).transformDirection(node_t_figure);
    const resize = (one: Figure, meters: number) => {
      set(one, meters);
      if (name !== "Ø") shift(one, normal, (meters - size) / 2);
    };
    return { name, at: at.applyMatrix4(node_t_figure), normal, size, sizePerMeter: name === "Ø" ? 2 : 1, resize };
  };
  if (kind === "box") {
    const { x, y, z } = value.size ?? { x: 0, y: 0, z: 0 };
    return AXES.flatMap((axis, place) => SIGNS.map((sign) => {
      const size = [x, y, z][place];
      return face(axis.toUpperCase(), place, sign, new Vector3().setComponent(place, (sign * size) / 2), size, (one, meters) => {
        if (one.geometry.case === "box" && one.geometry.value.size) one.geometry.value.size[axis] = meters;
      });
    }));
  }
  if (kind !== "sphere" && kind !== "cylinder" && kind !== "cone" && kind !== "capsule") return [];
  const radius = value.radiusMeters, length = "lengthMeters" in value ? value.lengthMeters : 0;
  const widest = kind === "cone" ? -length / 2 : 0; // a cone's base is below
  const sides = (kind === "sphere" ? [0, 1, 2] : [0, 1]).flatMap((axis) => SIGNS.map((sign) => {
    const at = new Vector3(0, 0, widest).setComponent(axis, sign * radius);
    return face("Ø", axis, sign, at, 2 * radius, ({ geometry: { value: one } }, meters) => {
      if (one && "radiusMeters" in one) one.radiusMeters = meters / 2;
    });
  }));
  if (kind === "sphere") return sides;
  const ends = SIGNS.map((sign) => {
    const at = new Vector3(0, 0, sign * (length / 2 + (kind === "capsule" ? radius : 0)));
    return face("Z", 2, sign, at, length, ({ geometry: { value: one } }, meters) => {
      if (one && "lengthMeters" in one) one.lengthMeters = meters;
    });
  });
  return [...sides, ...ends];
}

/** Shifts a figure in the frame of its node. */
function shift(figure: Figure, along: Vector3, meters: number): void {
  const by = new Matrix4().setPosition(along.clone().multiplyScalar(meters));
  figure.nodeTFigure = create(PoseSchema, poseOf(by.multiply(matrixOf(figure.nodeTFigure))));
}
