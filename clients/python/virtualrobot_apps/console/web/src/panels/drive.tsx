// Driving of a craft, while a key or a button is held.
import { useEffect } from "preact/hooks";
import type { GetRobotResponse, RobotState } from "../generated/virtualrobot/v1/robot_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { craftOf, speedLimit, turnLimit } from "../kernel/leads";
import { hold, release, wanted, type Parts } from "../kernel/setpoints";
import { HoldButton } from "./jog_button";

const AHEAD = [1, 0, 0], BACK = [-1, 0, 0], LEFT = [0, 0, 1], RIGHT = [0, 0, -1];
const KEYS: Record<string, Parts> = {
  KeyW: AHEAD, ArrowUp: AHEAD, KeyS: BACK, ArrowDown: BACK, KeyA: LEFT, ArrowLeft: LEFT, KeyD: RIGHT, ArrowRight: RIGHT,
  KeyQ: [0, 1, 0], KeyE: [0, -1, 0],
};

interface Props {
  robot: string;
  about: GetRobotResponse;
  state: RobotState;
}

export function Drive({ robot, about, state }: Props) {
  useEffect(() => release, [robot]);
  const keyed = (event: KeyboardEvent) => {
    const parts = KEYS[event.code];
    if (!parts || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (event.type === "keyup") release(event.code);
    else if (!event.repeat) hold(craftOf(robot), event.code, parts);
  };
  const button = (label: string, icon: string, parts: Parts) => (
    <HoldButton label={label} icon={icon} begin={() => hold(craftOf(robot), label, parts)} end={() => release(label)} />
  );
  const [speed, turning] = speeds(about, state);
  const [ahead, , turn] = wanted.value.length === 3 ? wanted.value : [0, 0, 0];
  return (
    <section aria-label="Drive">
      <h4>
        Drive
        <span class="grow" />
        <span class="muted mono" id="driven">{speed.toFixed(2)} m/s · {turning.toFixed(2)} rad/s</span>
      </h4>
      <div class="drive" data-keys role="application" tabIndex={0} aria-label="Drive by keys"
        title="Click here, then hold W A S D or the arrows; Q and E go sideways, where the craft can"
        onKeyDown={keyed} onKeyUp={keyed} onFocusOut={() => Object.keys(KEYS).forEach(release)}>
        {button("Turn left", "rotate-ccw", LEFT)}
        {button("Ahead", "arrow-up", AHEAD)}
        {button("Turn right", "rotate-cw", RIGHT)}
        <kbd>W A S D</kbd>
        {button("Back", "arrow-down", BACK)}
        <span class="muted mono" id="wanted" title="Twist that is told: m/s ahead, rad/s to the left">{ahead.toFixed(2)} {turn.toFixed(2)}</span>
      </div>
      <Limit label="Greatest speed" unit="m/s" most={1.5} limit={speedLimit} />
      <Limit label="Greatest turn" unit="rad/s" most={2} limit={turnLimit} />
    </section>
  );
}

function Limit({ label, unit, most, limit }: { label: string; unit: string; most: number; limit: typeof speedLimit }) {
  return (
    <div class="row" title={`${label} of this page; a craft whose drives can't is not driven`}>
      <span class="muted">{label}</span>
      <input class="slider grow" type="range" min="0.05" max={most} step="0.05" value={limit.value} aria-label={`${label}, ${unit}`}
        onInput={(event) => (limit.value = Number(event.currentTarget.value))} />
      <span class="mono limit">{limit.value.toFixed(2)} {unit}</span>
    </div>
  );
}

/** Returns how fast the craft's base goes (m/s) and turns (rad/s). */
function speeds(about: GetRobotResponse, state: RobotState): [number, number] {
  let place = 0;
  for (const joint of about.joints) {
    const v = state.velocities.slice(place, place + joint.velocityCount);
    if (joint.type === JointType.PLANAR) return [Math.hypot(v[0], v[1]), v[2]];
    if (joint.type === JointType.FLOATING) return [Math.hypot(v[0], v[1], v[2]), v[5]];
    place += joint.velocityCount;
  }
  return [0, 0];
}
