// The pendant: joints, jogs of the tool centre point, where it is, tools, and where the robot shall go.
import { signal } from "@preact/signals";
import { Role } from "../generated/virtualrobot/v1/token_pb";
import { isCraft } from "../kernel/devices";
import { goal } from "../kernel/goal";
import { jogSpeed } from "../kernel/jog";
import { teach } from "../kernel/orders";
import { giveBack, isLeasedHere, lease } from "../kernel/own_leases";
import { otherMover } from "../kernel/own_motions";
import { personOf } from "../kernel/words";
import { chosen, info, leases, robotNames, robots, selected, states } from "../kernel/world";
import { Icon } from "../parts/icons";
import { NotationChoice, PoseFields } from "../parts/pose_fields";
import { DevicesButton, DevicesHeld } from "./devices";
import { Drive } from "./drive";
import { Joints } from "./joints";
import { NoRobot } from "./no_robot";
import { PendantSignals } from "./pendant_io";
import { ToolJog } from "./tool_jog";
import { Tools } from "./tools";

export function Pendant() {
  const name = chosen.value;
  const about = robots.value.get(name), state = states.value.get(name);
  if (!about || !state) return <NoRobot />;
  const owner = ownerOf(name);
  return (
    <>
      <div class="body" id="pendant">
        <div class="row">
          <select class="select grow" aria-label="Robot" value={name} onChange={(event) => (chosen.value = selected.value = event.currentTarget.value)}>
            {robotNames.value.map((one) => <option key={one} value={one}>{one}</option>)}
          </select>
          <span class="select readonly" title="The tool that poses are of">{state.tool || "flange"}</span>
          <LeaseButton robot={name} />
          <DevicesButton />
        </div>
        <DevicesHeld />
        {owner && !isLeasedHere(name) && (
          <p class="hint warned">
            <Icon name="lock" size={13} /> {personOf(owner)} has leased it: others can't move it.
            <button type="button" class="chip" title={`Take ${name} over: its motions stop, and ${personOf(owner)} is told`} onClick={() => void lease(name, true)}>Take over</button>
          </p>
        )}
        {otherMover.value && <p class="hint warned" role="status"><Icon name="users" size={13} /> Somebody else moves {name} ({otherMover.value}).</p>}
        {isCraft(name) && <Drive robot={name} about={about} state={state} />}
        <Joints robot={name} about={about} state={state} />
        <ToolJog robot={name} />
        <section>
          <h4>
            Tool in world
            <span class="grow" />
            <button type="button" class="chip" title="Keep this place as a target of the world" aria-label="Teach target" onClick={() => void teach(name)}>
              <Icon name="map-pin" size={13} />Teach
            </button>
            <NotationChoice />
          </h4>
          <PoseFields pose={goal.pose.value ?? state.worldTTcp} write={(edit) => void goal.ask(name, edit(goal.pose.peek() ?? states.peek().get(name)?.worldTTcp))} />
        </section>
        <Tools robot={name} state={state} />
        <PendantSignals />
        <Branches />
      </div>
      <Go />
    </>
  );
}

/** Returns who has leased a robot, "" where nobody has. */
function ownerOf(robot: string): string {
  return leases.value.find(({ robots }) => robots.includes(robot))?.owner ?? "";
}

/** Leases the robot for this page, or gives it back. */
function LeaseButton({ robot }: { robot: string }) {
  const isOwn = isLeasedHere(robot), isOthers = !isOwn && ownerOf(robot) !== "";
  const may = (info.value?.role ?? Role.OBSERVER) >= Role.OPERATOR;
  const title = isOwn ? "Give it back: others may move it again" : may ? "Lease it: nobody else moves it until it is given back, or this page is gone" : "An observer looks: an operator leases and moves";
  return (
    <button type="button" class="tool" aria-label={isOwn ? "Give back" : "Lease"} aria-pressed={isOwn} disabled={isOthers || !may} title={title} onClick={() => void (isOwn ? giveBack(robot) : lease(robot))}>
      <Icon name="lock" size={16} color={isOwn ? "var(--accent)" : undefined} />
    </button>
  );
}

/** Whether full turns of joints are postures of their own to click through. */
const withTurns = signal(false);
const MOST_CHIPS = 64;

/** Postures that reach the wanted place, to click through: of each way the nearest, or the turns of the way that is shown. */
export function Branches() {
  const unreachable = goal.reach.value === "unreachable";
  if (!goal.isPose && !unreachable) return null;
  const all = goal.branches.value.map((one, place) => ({ ...one, place }));
  const shown = all[goal.branch.value]?.way;
  const nearest = [...new Map(all.toReversed().map((one) => [one.way, one] as const)).values()].sort((one, other) => one.place - other.place);
  const turns = all.length - nearest.length;
  const chips = withTurns.value && turns > 0 ? all.filter(({ way }) => way === shown) : nearest;
  return (
    <section aria-label="Postures">
      <h4>
        {unreachable ? <span class="bad">Out of reach</span> : <span>Postures <span class="muted">{nearest.length}</span></span>}
        {turns > 0 && (
          <button type="button" class="chip" aria-pressed={withTurns.value} title="The same posture with joints turned by whole turns, each as far as its limits let it" onClick={() => (withTurns.value = !withTurns.value)}>
            Full turns
          </button>
        )}
      </h4>
      {unreachable && <p class="hint">{goal.explanation.value}</p>}
      <div class="chips">
        {chips.slice(0, MOST_CHIPS).map(({ name, way, place }) => (
          <button key={place} type="button" class="chip" aria-pressed={withTurns.value ? goal.branch.value === place : shown === way} onClick={() => (goal.branch.value = place)}>
            {withTurns.value ? name : way}
          </button>
        ))}
      </div>
    </section>
  );
}

/** Lets the robot go where its ghost is. */
export function Go() {
  if (!goal.shown.value) return null;
  return (
    <div class="footer">
      {goal.isPose && (
        <select class="select way" aria-label="Way" value={goal.way.value} onChange={(event) => (goal.way.value = event.currentTarget.value as "PTP" | "LIN")}>
          <option value="PTP" title="Joints together">PTP</option>
          <option value="LIN" title="The tool in a straight line">LIN</option>
        </select>
      )}
      <button type="button" class="button primary grow" id="go" onClick={() => void goal.go()}>
        <Icon name="play" size={14} />Move to ghost
      </button>
      <button type="button" class="button" title="Drop the ghost (Esc)" onClick={() => goal.clear()}><Icon name="x" size={14} /></button>
    </div>
  );
}

export function JogSpeed() {
  const percent = Math.round(100 * jogSpeed.value);
  return (
    <div class="row" title="Speed of jogs, of the greatest one for teaching">
      <span class="muted">Jog speed</span>
      <input class="slider grow" type="range" min="5" max="100" step="5" value={percent} aria-label="Jog speed, %"
        onInput={(event) => (jogSpeed.value = Number(event.currentTarget.value) / 100)} />
      <span class="mono percent">{percent} %</span>
    </div>
  );
}
