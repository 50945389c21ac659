// A joint between two bodies: which axis, which body moves on which, how and how far.
import { signal } from "@preact/signals";
import { Vector3 } from "three";
import { Icon } from "../parts/icons";
import { Choice } from "../parts/choice";
import { NodeField } from "../parts/node_field";
import { NumberField } from "../parts/number_field";
import { DEGREES, fixed } from "../parts/numbers";
import { items, selected } from "../kernel/world";
import { grows, isBody, joint, limits, makeJoint, missing, picked, picking, reverse, takeAxis, togglePicking, type Motion } from "../view/jointing";
import { takeApart } from "../view/parting";
import { viewport } from "./view";

const MOTIONS: readonly (readonly [Motion, string])[] = [["turns", "turns"], ["turns freely", "turns freely"], ["slides", "slides"]];

export function Jointing() {
  const { moves, on, motion, name } = joint.value;
  const change = (some: Partial<typeof joint.value>) => (joint.value = { ...joint.peek(), ...some });
  const taken = (which: "moves" | "on") => (
    <button type="button" class="tool small" disabled={!selected.value} title={`The selected node: ${selected.value || "none"}`} onClick={() => change({ [which]: selected.peek() })}><Icon name="mouse-pointer-2" size={13} /></button>
  );
  return (
    <div class="list jointing" aria-label="A joint between two bodies">
      <div class="entry">
        <Icon name="axis-3d" size={14} color="var(--part)" />
        <button type="button" class="button small" aria-pressed={picking.value} title="Then click at the wall of a hole or a pin, or at an edge, in the view" onClick={togglePicking}>
          {picking.value ? "Click at a hole or an edge …" : "Pick an axis"}
        </button>
        <FrameAxis />
        <span id="picked-axis" class="mono grow cut" title={told()}>{told()}</span>
        {!picked.value && (
          <button type="button" class="button small" disabled={!isBody(items.value.get(selected.value))} title="Make each body of the selected node's file a node of its own, which hangs on it"
            onClick={() => viewport.current && void takeApart(viewport.current, selected.peek())}>Take apart</button>
        )}
        {picked.value && <button type="button" class="button small" title="Joints go up where the axis points, by the right hand" onClick={reverse}>Other way</button>}
      </div>
      <div class="entry">
        <Icon name="link" size={14} color="var(--muted)" />
        <NodeField label="The body that moves" value={moves} placeholder="body" choose={(one) => change({ moves: one })} />{taken("moves")}
        <Choice label="How it moves" options={MOTIONS} chosen={motion} choose={(one) => change({ motion: one })} />
        <span class="muted">on</span>
        <NodeField label="The body, or the link, that it moves on" value={on} placeholder="base" choose={(one) => change({ on: one })} />{taken("on")}
        {motion !== "turns freely" && <Limits motion={motion} />}
      </div>
      <div class="entry">
        <Icon name="robot" size={14} color="var(--robot)" />
        {!grows.value && (
          <label class="field node-field" title="The name of the device">
            <input aria-label="Name of the device" placeholder="device" value={name} onInput={(event) => change({ name: event.currentTarget.value })} />
          </label>
        )}
        <button type="button" class="button small primary" disabled={missing.value !== ""} title="Both bodies become links of a robot: one step, which undo takes back" onClick={() => viewport.current && void makeJoint(viewport.current)}>Make the joint</button>
        <span class="grow cut muted" role="status">{missing.value}</span>
      </div>
    </div>
  );
}

const AXES = ["x", "y", "z"] as const;
const axisNode = signal("");

/** Takes an axis of a node's own frame, by keys alone. */
function FrameAxis() {
  const node = axisNode.value;
  const along = (axis: (typeof AXES)[number]) => {
    const direction = new Vector3().setComponent(AXES.indexOf(axis), 1);
    if (items.peek().has(node)) takeAxis(node, { kind: "frame axis", point: new Vector3(), direction, radius: 0, length: 0 });
  };
  return (
    <>
      <span class="muted">or</span>
      <NodeField label="A node, through whose origin the axis goes" value={node} placeholder="a node's" choose={(one) => (axisNode.value = one)} />
      {AXES.map((axis) => (
        <button key={axis} type="button" class="chip" disabled={!items.value.has(node)} title={`The axis ${axis} of its frame`} aria-label={`The axis ${axis} of the node`} onClick={() => along(axis)}>{axis}</button>
      ))}
    </>
  );
}

function Limits({ motion }: { motion: "turns" | "slides" }) {
  const [factor, unit] = motion === "slides" ? [1000, "mm"] as const : [DEGREES, "°"] as const;
  return (["Least", "Greatest"] as const).map((label, at) => (
    <NumberField key={label} label={`${label} position`} value={factor * limits.value[motion][at]} unit={unit} decimals={1}
      write={(to) => (limits.value = { ...limits.peek(), [motion]: limits.peek()[motion].with(at, to / factor) })} />
  ));
}

/** Tells the picked axis: in its node's frame, mm. */
function told(): string {
  if (!picked.value) return "";
  const { node, axis: { kind, point, direction, radius } } = picked.value;
  const size = radius > 0 ? ` Ø ${fixed(2000 * radius, 2)} mm` : "";
  const at = point.toArray().map((value) => fixed(1000 * value, 1)).join(" "), along = direction.toArray().map((value) => fixed(value, 3)).join(" ");
  return `${kind}${size} of ${node} at ${at} mm along ${along}`;
}
