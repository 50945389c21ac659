// Parts: how far they are from where the robot's tool holds things, picked and placed by a click, and what is held.
import { effect, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Vector3 } from "three";
import { askedAnew } from "../kernel/asked_anew";
import { goal } from "../kernel/goal";
import * as parts from "../kernel/parts";
import { chosen, items, robotNames, selected, states } from "../kernel/world";
import { Icon, KindIcon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import { NumberField } from "../parts/number_field";
import { fixed, orientationOf } from "../parts/numbers";
import { matrixOf } from "../view/poses";
import { showSpans } from "../view/spans";
import { NoRobot } from "./no_robot";
import { Branches, Go } from "./pendant";
import { Tools } from "./tools";
import { viewport } from "./view";

/** Where a part is: in the world, and from the tool centre point along its axes; meters. */
interface Near {
  name: string;
  point: Vector3;
  offset: Vector3;
  meters: number;
}

const MOST_ROWS = 100;
const COLORS = { within: "#35c27b", beyond: "#e5393f" };
const AXES = ["X", "Y", "Z"] as const;

/** All parts, the nearest to the chosen robot's tool centre point first. */
const near = signal<readonly Near[]>([]);

export function Parts() {
  const robot = chosen.value, state = states.value.get(robot);
  useEffect(() => askedAnew(async () => measure(robot)), [robot, items.value]);
  useEffect(() => effect(showWay), []);
  useEffect(() => () => showSpans("grasp", []), []);
  if (!state) return <NoRobot />;
  const tool = state.tool ?? "";
  return (
    <>
      <div class="body" id="parts">
        <div class="row">
          <select class="select grow" aria-label="Robot that handles parts" value={robot} onChange={(event) => (chosen.value = event.currentTarget.value)}>
            {robotNames.value.map((one) => <option key={one} value={one}>{one}</option>)}
          </select>
          <ToolChoice robot={robot} tool={tool} point={state.toolCenterPoint} tools={Object.keys(state.toolStates)} />
        </div>
        {!tool && <p class="hint warned"><Icon name="triangle-alert" size={13} /> {robot} works with no tool, and can't pick: mount one from the library.</p>}
        <Tools robot={robot} state={state} />
        {parts.refused.value && <p class="hint warned" role="alert"><Icon name="triangle-alert" size={13} /><span class="grow words">{parts.refused.value}</span></p>}
        <Held robot={robot} tool={tool} />
        <Chosen robot={robot} tool={tool} />
        <List robot={robot} tool={tool} />
        <Branches />
      </div>
      <Go />
    </>
  );
}

function ToolChoice({ robot, tool, point, tools }: { robot: string; tool: string; point: string; tools: readonly string[] }) {
  const kind = items.value.get(tool)?.node.kind;
  const points = kind?.case === "tool" ? kind.value.toolCenterPoints.map(({ name }) => name) : [];
  return (
    <>
      <select class="select grow" aria-label="Tool that holds parts" value={tool} onChange={(event) => void parts.selectTool(robot, event.currentTarget.value)}>
        <option value="">no tool</option>
        {tools.map((one) => <option key={one} value={one}>{one}</option>)}
      </select>
      {points.length > 1 && (
        <select class="select" aria-label="Tool centre point" value={point} onChange={(event) => void parts.selectTool(robot, tool, event.currentTarget.value)}>
          {points.map((one) => <option key={one} value={one}>{one}</option>)}
        </select>
      )}
    </>
  );
}

function Held({ robot, tool }: { robot: string; tool: string }) {
  const held = parts.heldBy(tool);
  return (
    <section aria-label="Held">
      <h4>
        <span>Held <span class="muted">{held.length || "nothing"}</span></span>
        {held.length > 1 && <button type="button" class="chip" onClick={() => void parts.place(robot, "")}>Place all</button>}
      </h4>
      {held.map(({ name }) => (
        <div key={name} class="entry part" aria-label={`${name}, held`} role="group">
          <KindIcon kind="part" size={14} />
          <button type="button" class="link grow" onClick={() => (selected.value = name)}>{name}</button>
          <button type="button" class="button small primary" title={`Let ${name} go where it is, fixed to ${parts.ground.value}`} onClick={() => void parts.place(robot, name)}>Place</button>
        </div>
      ))}
      {held.length > 0 && (
        <div class="row">
          <NodeField label="What parts are placed on" name="on" value={parts.ground.value} choose={(name) => (parts.ground.value = name || "world")} />
          <button type="button" class="tool small" disabled={!selected.value} title={`The selected node: ${selected.value || "none"}`} onClick={() => (parts.ground.value = selected.peek())}><Icon name="mouse-pointer-2" size={13} /></button>
        </div>
      )}
    </section>
  );
}

/** The part that is selected: how far it is, and the robot's way there. */
function Chosen({ robot, tool }: { robot: string; tool: string }) {
  const item = items.value.get(selected.value);
  const one = near.value.find(({ name }) => name === item?.name);
  if (!item || !one || parts.holderOf(one.name) === tool) return null;
  const isNear = one.meters <= parts.graspMeters.value;
  return (
    <section aria-label="Chosen part">
      <h4>
        <span class="row"><KindIcon kind="part" /><span class="cut">{one.name}</span></span>
        <Distance meters={one.meters} />
      </h4>
      <div class="pose">
        {AXES.map((axis, place) => (
          <NumberField key={axis} label={`From the tool centre point along its ${axis}`} name={`Δ${axis}`} color={`var(--${axis.toLowerCase()})`} unit="mm" decimals={1} value={1000 * one.offset.getComponent(place)} />
        ))}
      </div>
      <div class="row">
        <button type="button" class={`button grow ${isNear ? "" : "primary"}`} id="reach" title="A ghost of the robot with its tool centre point there, turned as it is now" onClick={() => reach(robot, one)}><Icon name="crosshair" size={14} />Reach</button>
        <button type="button" class={`button grow ${isNear ? "primary" : ""}`} id="pick" title={`Fix ${one.name} to the tool where it is`} onClick={() => void parts.pick(robot, one.name)}><Icon name="hand-grab" size={14} />Pick</button>
      </div>
    </section>
  );
}

function Distance({ meters }: { meters: number }) {
  const within = meters <= parts.graspMeters.value;
  return <span class={`mono distance ${within ? "good" : "bad"}`} title={within ? "Near enough to be picked" : "Too far to be picked"}>{fixed(1000 * meters, 1)} mm</span>;
}

function List({ robot, tool }: { robot: string; tool: string }) {
  const free = near.value.filter(({ name }) => !tool || parts.holderOf(name) !== tool);
  return (
    <section aria-label="Parts">
      <h4>
        <span class="grow">Parts</span>
        <NumberField label="Farthest that the origin of a part may be from the tool centre point to be picked" name="within" value={1000 * parts.graspMeters.value} unit="mm" decimals={0} write={(to) => (parts.graspMeters.value = Math.max(0.001, to / 1000))} />
        <button type="button" class="chip" title="The part whose origin is nearest to the tool centre point" onClick={() => void parts.pick(robot, "")}>Pick nearest</button>
      </h4>
      {free.length === 0 && <p class="hint">There is no part here to be picked.</p>}
      <div role="list" aria-label="Parts by distance">
        {free.slice(0, MOST_ROWS).map(({ name, meters }) => {
          const holder = parts.holderOf(name);
          return (
            <div key={name} class="entry part" role="listitem" aria-label={name}>
              <KindIcon kind="part" size={14} />
              <button type="button" class="pair grow" aria-pressed={selected.value === name} onClick={() => (selected.value = name)}>
                <span class="cut">{name}</span>{holder && <span class="muted cut">{holder} holds it</span>}
              </button>
              <Distance meters={meters} />
            </div>
          );
        })}
      </div>
      {free.length > MOST_ROWS && <p class="hint">and {free.length - MOST_ROWS} farther ones</p>}
    </section>
  );
}

function measure(robot: string): void {
  const tcp = states.peek().get(robot)?.worldTTcp, places = viewport.current?.solids.places;
  if (!tcp || !places) {
    near.value = [];
    return;
  }
  const tcp_t_world = matrixOf(tcp).invert();
  const found: Near[] = [];
  for (const { name, kind } of items.peek().values()) {
    const place = kind === "part" && places.get(name);
    if (!place) continue;
    const point = new Vector3().setFromMatrixPosition(place), offset = point.clone().applyMatrix4(tcp_t_world);
    found.push({ name, point, offset, meters: offset.length() });
  }
  near.value = found.sort((one, other) => one.meters - other.meters);
}

/** Draws the way from the tool centre point to the part that is selected. */
function showWay(): void {
  const one = near.value.find(({ name }) => name === selected.value);
  const from = states.peek().get(chosen.value)?.worldTTcp?.position;
  const color = one && one.meters <= parts.graspMeters.value ? COLORS.within : COLORS.beyond;
  showSpans("grasp", one && from && parts.holderOf(one.name) !== states.peek().get(chosen.value)?.tool ? [{ from, to: one.point, color }] : []);
}

function reach(robot: string, { point: { x, y, z } }: Near): void {
  void goal.ask(robot, { position: { x, y, z }, orientation: orientationOf(states.peek().get(robot)?.worldTTcp) });
}
