// Traces as lines in the view, each as wide as a pen's.
import { effect } from "@preact/signals";
import { Vector3 } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { follow, gone, MOST, traces, ways } from "../kernel/traces";
import { hearers } from "../kernel/world";
import type { Viewport } from "./viewport";

const WIDTH_PIXELS = 2.5;

type Drawn = LineSegments2 & { geometry: LineSegmentsGeometry; material: LineMaterial };

/** Draws all traces into a view from now on, and follows what is traced. */
export function drawTraces(view: Viewport): void {
  const drawn = new Map<string, Drawn>();
  effect(() => {
    void gone.value;
    const wanted = new Map(traces.value.map((one) => [one.node, one]));
    for (const [node, line] of drawn) {
      if (wanted.has(node)) continue;
      view.overlay.remove(line);
      line.geometry.dispose();
      drawn.delete(node);
    }
    for (const { node, color } of wanted.values()) {
      let line = drawn.get(node);
      if (!line) {
        line = empty();
        drawn.set(node, line);
        view.overlay.add(line);
      }
      line.material.color.set(color);
      fill(line, ways.get(node)?.segments() ?? []);
    }
    view.invalidate();
  });
  const at = new Vector3();
  const placeOf = (node: string) => {
    const place = view.solids.places.get(node);
    return place && (at.setFromMatrixPosition(place).toArray() as [number, number, number]);
  };
  hearers.states.add(() => void follow(placeOf));
  hearers.poses.add(() => void follow(placeOf));
}

function empty(): Drawn {
  // Room for the longest one: what has been drawn once doesn't grow.
  const geometry = new LineSegmentsGeometry().setPositions(new Float32Array(6 * MOST));
  const line = new LineSegments2(geometry, new LineMaterial({ linewidth: WIDTH_PIXELS, transparent: true, opacity: 0.9 })) as Drawn;
  line.frustumCulled = false;
  line.visible = false;
  return line;
}

function fill(line: Drawn, segments: readonly number[]): void {
  const { data } = line.geometry.getAttribute("instanceStart") as unknown as { data: { array: Float32Array; needsUpdate: boolean } };
  data.array.set(segments);
  data.needsUpdate = true;
  line.geometry.instanceCount = segments.length / 6;
  line.visible = segments.length > 0;
}
