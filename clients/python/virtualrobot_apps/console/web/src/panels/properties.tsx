// Properties of what is selected: common ones, and those of its kind as the contract's descriptors tell them.
import { create } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { Matrix4 } from "three";
import { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import { attach, change, rename, run, setHidden } from "../kernel/orders";
import { items, moves, robots, selected, states, type Item } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon, KindIcon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import type { AnyPose } from "../parts/numbers";
import { NotationChoice, PoseFields } from "../parts/pose_fields";
import { TextRow } from "../parts/text_row";
import { matrixOf, poseOf } from "../view/poses";
import { About } from "./about";
import { Figures } from "./figures";
import { KindFields } from "./kind_fields";
import { viewport } from "./view";

const FRAMES = [["parent", "Parent"], ["world", "World"], ["node", "Node"]] as const;

/** The frame in which poses are told and written: of "node" that of the named one. */
const frame = signal<(typeof FRAMES)[number][0]>("parent");
const frameNode = signal("");

/** Returns the node in whose frame the pose of another one is told; its parent where the named one is gone. */
function frameOf({ parent }: Item): string {
  if (frame.value === "world") return "world";
  return frame.value === "node" && items.value.has(frameNode.value) ? frameNode.value : parent;
}

export function Properties() {
  const item = items.value.get(selected.value);
  if (!item) return <div class="body"><p class="hint">Select something in the scene.</p></div>;
  const isWorld = item.kind === "world";
  return (
    <div class="body" id="properties">
      <section>
        <h4><span class="row"><KindIcon kind={item.kind} icon={item.node.icon} />{words(item.kind)}</span></h4>
        <TextRow key={item.name} label="Name" value={item.name} write={isWorld ? undefined : (to) => void rename(item.name, to)} />
        {!isWorld && <ParentRow item={item} />}
        {!isWorld && (
          <div class="property">
            <span>Visible</span>
            <button type="button" role="switch" class="switch" aria-label="Visible" aria-checked={!item.hidden} onClick={() => void setHidden(item.name, !item.hidden)} />
          </div>
        )}
      </section>
      {!isWorld && <About item={item} />}
      {!isWorld && (
        <section>
          <h4><span class="cut">Pose in {frameOf(item)}</span><NotationChoice /></h4>
          <div class="row">
            <Choice label="Frame of the pose" options={FRAMES} chosen={frame.value} choose={(one) => (frame.value = one)} />
            {frame.value === "node" && <NodeField label="The node in whose frame the pose is" value={frameNode.value} placeholder="a node" choose={(one) => (frameNode.value = one)} />}
          </div>
          <Pose item={item} />
        </section>
      )}
      {item.node.kind.case === "target" && <Target item={item} robot={item.node.kind.value.robot} />}
      <KindFields item={item} />
      {item.kind === "robot" && <Robot name={item.name} />}
      <Figures item={item} />
    </div>
  );
}

/** Where a node is now, in its parent, in the world or in another node. */
function Pose({ item }: { item: Item }) {
  void moves.value;
  const { name, parent, kind, node } = item, told = frameOf(item);
  const places = viewport.current?.solids.places;
  // The world is where it is, told or not.
  const placeOf = (one: string) => (one === "world" ? new Matrix4() : places?.get(one));
  const here = placeOf(name), below = placeOf(parent), within = placeOf(told);
  const pose = here && within ? poseOf(within.clone().invert().multiply(here)) : node.parentTNode;
  const write = (edit: (pose?: AnyPose) => AnyPose) => void change(name, "parent_t_node", (one) => {
    if (told === parent || !below || !within) {
      one.parentTNode = create(PoseSchema, edit(one.parentTNode));
      return;
    }
    const parent_t_frame = below.clone().invert().multiply(within);
    const edited = edit(poseOf(parent_t_frame.clone().invert().multiply(matrixOf(one.parentTNode))));
    one.parentTNode = create(PoseSchema, poseOf(parent_t_frame.multiply(matrixOf(edited))));
  });
  return <PoseFields pose={pose} write={kind === "link" ? undefined : write} />;
}

function ParentRow({ item: { name, parent, kind } }: { item: Item }) {
  const fixed = kind === "link";
  return (
    <div class="property">
      <span>Parent</span>
      {fixed ? <button type="button" class="link" onClick={() => (selected.value = parent)}>{parent}</button>
        : <NodeField label="Parent: what it hangs on; it stays where it is" value={parent} choose={(to) => to !== parent && void attach(name, to)} />}
      {!fixed && parent !== "world" && (
        <button type="button" class="tool small" title="Hang it on the world; it stays where it is" onClick={() => void attach(name, "world")}>
          <Icon name="x" size={13} />
        </button>
      )}
    </div>
  );
}

/** Lets a robot go to a place that was taught. */
function Target({ item, robot }: { item: Item; robot: string }) {
  const reference = item.name;
  if (!robots.value.has(robot)) return null;
  const pose = { reference };
  return (
    <section>
      <h4>Go there with {robot}</h4>
      <div class="row">
        <button type="button" class="button grow" title="Joints together"
          onClick={() => void run({ moves: [{ robot, speedFactor: 0.5, move: { case: "pointToPoint", value: { goal: { case: "pose", value: pose } } } }] })}>
          <Icon name="play" size={14} />PTP
        </button>
        <button type="button" class="button grow" title="The tool in a straight line"
          onClick={() => void run({ moves: [{ robot, speedFactor: 0.5, move: { case: "linear", value: { goal: pose } } }] })}>
          <Icon name="play" size={14} />LIN
        </button>
      </div>
    </section>
  );
}

function Robot({ name }: { name: string }) {
  const about = robots.value.get(name);
  if (!about) return null;
  const postures = about.robot?.postures ?? [];
  return (
    <section>
      <h4>Robot</h4>
      <div class="property"><span>Joints</span><span>{about.joints.length}</span></div>
      <div class="property"><span>Solved by</span><span>{about.kinematics}</span></div>
      <div class="property"><span>Tool</span><span>{states.value.get(name)?.tool || "none"}</span></div>
      {postures.length > 0 && (
        <div class="chips">
          {postures.map((posture) => (
            <button key={posture.name} type="button" class="chip" title="Go to this posture"
              onClick={() => void run({ moves: [{ robot: name, speedFactor: 0.5, move: { case: "pointToPoint", value: { goal: { case: "posture", value: posture.name } } } }] })}>
              <Icon name="play" size={11} />{posture.name}
            </button>
          ))}
        </div>
      )}
    </section>
  );
}

function words(kind: string): string {
  const text = kind.replace(/[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`);
  return text[0].toUpperCase() + text.slice(1);
}
