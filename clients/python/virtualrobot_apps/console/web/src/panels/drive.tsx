// Driving of a craft, while a key, a button or the dead man's button of a gamepad is held.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { GetRobotResponse, RobotState } from "../generated/virtualrobot/v1/robot_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { hold, release, speedLimit, turnLimit, wanted, type Twist } from "../kernel/drive";
import { drivePad, releasePad } from "../kernel/gamepad";
import { Icon } from "../parts/icons";
import { HoldButton } from "./jog_button";

const AHEAD: Twist = [1, 0, 0], BACK: Twist = [-1, 0, 0], LEFT: Twist = [0, 0, 1], RIGHT: Twist = [0, 0, -1];
const KEYS: Record<string, Twist> = {
  KeyW: AHEAD, ArrowUp: AHEAD, KeyS: BACK, ArrowDown: BACK, KeyA: LEFT, ArrowLeft: LEFT, KeyD: RIGHT, ArrowRight: RIGHT,
  KeyQ: [0, 1, 0], KeyE: [0, -1, 0],
};
const PAD_MS = 50;

interface Props {
  robot: string;
  about: GetRobotResponse;
  state: RobotState;
}

/** Returns whether a robot drives by twists; what swims is told its thrusters instead. */
export function isCraft({ robot }: GetRobotResponse): boolean {
  return !!robot?.craft?.kinematics && !robot.craft.water;
}

export function Drive({ robot, about, state }: Props) {
  const pad = useSignal("");
  useEffect(() => {
    const timer = setInterval(() => (pad.value = drivePad(robot)), PAD_MS);
    return () => {
      clearInterval(timer);
      releasePad();
      release();
    };
  }, [robot]);
  const keyed = (event: KeyboardEvent) => {
    const parts = KEYS[event.code];
    if (!parts || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (event.type === "keyup") release(event.code);
    else if (!event.repeat) hold(robot, event.code, parts);
  };
  const button = (label: string, icon: string, parts: Twist) => (
    <HoldButton label={label} icon={icon} begin={() => hold(robot, label, parts)} end={() => release(label)} />
  );
  const [speed, turning] = speeds(about, state);
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
        <span class="muted mono" id="wanted" title="Twist that is told">{wanted.value[0].toFixed(2)} {wanted.value[2].toFixed(2)}</span>
      </div>
      <Limit label="Greatest speed" unit="m/s" most={1.5} limit={speedLimit} />
      <Limit label="Greatest turn" unit="rad/s" most={2} limit={turnLimit} />
      <p class="hint"><Icon name="gamepad-2" size={13} /> {pad.value ? `${pad.value}: hold the right shoulder button` : "No gamepad: press one of its buttons"}</p>
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
