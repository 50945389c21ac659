// Jogs of the tool centre point along and about axes of the base, the tool or the world.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { toolOf } from "../kernel/leads";
import { heldBy, hold, release } from "../kernel/setpoints";
import { Choice } from "../parts/choice";
import { HoldButton } from "./jog_button";
import { JogSpeed } from "./pendant";

const AXES = ["X", "Y", "Z", "RX", "RY", "RZ"];
const COLORS = ["var(--x)", "var(--y)", "var(--z)"];

const frame = signal<"base" | "tool" | "world">("base");

export function ToolJog({ robot }: { robot: string }) {
  useEffect(() => release, [robot]);
  const button = (axis: number, sign: number) => {
    const label = `${AXES[axis]} ${sign > 0 ? "plus" : "minus"}`;
    const parts = AXES.map((_, place) => (place === axis ? sign : 0));
    return <HoldButton label={label} icon={sign > 0 ? "plus" : "minus"} begin={() => hold(toolOf(robot, frame.value), label, parts)} end={() => release(label)} />;
  };
  return (
    <section aria-label="Tool centre point">
      <h4>
        <span class="cut">Tool centre point</span>
        {heldBy.value && <span class="warned cut" role="status" title="The other way it is free">{heldBy.value === "singularity" ? "a singularity is near" : `${heldBy.value} holds it up`}</span>}
        <Choice label="Axes" options={[["base", "Base"], ["tool", "Tool"], ["world", "World"]]} chosen={frame.value} choose={(one) => (frame.value = one)} />
      </h4>
      <div class="axes">
        {AXES.map((axis, place) => (
          <div key={axis} class="axis">
            {button(place, 1)}
            <span style={{ color: COLORS[place % 3] }}>{axis}</span>
            {button(place, -1)}
          </div>
        ))}
      </div>
      <JogSpeed />
    </section>
  );
}
