// Jogs of the tool centre point along and about axes of the base, the tool, the world or a node that a person names.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { toolOf } from "../kernel/leads";
import { heldBy, hold, release } from "../kernel/setpoints";
import { items } from "../kernel/world";
import { Choice } from "../parts/choice";
import { NodeField } from "../parts/node_field";
import { HoldButton } from "./jog_button";
import { JogSpeed } from "./pendant";

const AXES = ["X", "Y", "Z", "RX", "RY", "RZ"];
const COLORS = ["var(--x)", "var(--y)", "var(--z)"];

const FRAMES = [
  ["base", "Base", "Along and about the axes of the robot's base"], ["tool", "Tool", "Along and about the tool's own axes"],
  ["world", "World", "Along and about the axes of the world"], ["user", "User", "Along and about the axes of a node that is named"],
] as const;

const frame = signal<(typeof FRAMES)[number][0]>("base");
/** The user frame: a node. */
const user = signal("");

export function ToolJog({ robot }: { robot: string }) {
  useEffect(() => release, [robot]);
  const node = frame.value === "user" ? (items.value.has(user.value) ? user.value : "world") : "";
  const button = (axis: number, sign: number) => {
    const label = `${AXES[axis]} ${sign > 0 ? "plus" : "minus"}`;
    const parts = AXES.map((_, place) => (place === axis ? sign : 0));
    return <HoldButton label={label} icon={sign > 0 ? "plus" : "minus"} begin={() => hold(toolOf(robot, frame.value, node), label, parts)} end={() => release(label)} />;
  };
  return (
    <section aria-label="Tool centre point">
      <h4>
        <span class="cut">Tool centre point</span>
        {heldBy.value && <span class="warned cut" role="status" title="The other way it is free">{heldBy.value === "singularity" ? "a singularity is near" : `${heldBy.value} holds it up`}</span>}
        <Choice label="Axes" options={FRAMES} chosen={frame.value} choose={(one) => (frame.value = one)} />
      </h4>
      {node && <NodeField label="User frame: the node along whose axes the tool goes" name="User frame" value={user.value} placeholder="world" choose={(name) => (user.value = name)} />}
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
