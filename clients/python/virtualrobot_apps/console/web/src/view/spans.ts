// Straight lines between two points, such as the nearest ones of two nodes: seen through everything, as wide as a pen's.
import { effect, signal } from "@preact/signals";
import { Color } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import type { Vector3 } from "../generated/virtualrobot/v1/geometry_pb";
import type { Viewport } from "./viewport";

type Point = Pick<Vector3, "x" | "y" | "z">;

export interface Span {
  from: Point;
  to: Point;
  /** `#rrggbb`. */
  color: string;
}

const WIDTH_PIXELS = 2.5;
const ORDER = 940;

/** Lines that are drawn, by who wants them. */
const spans = signal<ReadonlyMap<string, readonly Span[]>>(new Map());

/** Draws these lines in place of those that the same owner had before. */
export function showSpans(owner: string, wanted: readonly Span[]): void {
  spans.value = new Map(spans.peek()).set(owner, wanted);
}

/** Draws all of them into a view from now on. */
export function drawSpans(view: Viewport): void {
  const material = new LineMaterial({ linewidth: WIDTH_PIXELS, vertexColors: true, depthTest: false, transparent: true, toneMapped: false });
  const line = new LineSegments2(new LineSegmentsGeometry(), material);
  line.frustumCulled = false;
  line.renderOrder = ORDER;
  view.overlay.add(line);
  effect(() => {
    const all = [...spans.value.values()].flat();
    line.visible = all.length > 0;
    if (line.visible) {
      line.geometry.dispose();
      line.geometry = new LineSegmentsGeometry();
      line.geometry.setPositions(all.flatMap(({ from, to }) => [from.x, from.y, from.z, to.x, to.y, to.z]));
      line.geometry.setColors(all.flatMap(({ color }) => [...new Color(color).toArray(), ...new Color(color).toArray()]));
    }
    view.invalidate();
  });
}
