// Joints: jogged by their buttons while these are held, wanted elsewhere by their sliders.
import { useRef } from "preact/hooks";
import type { JointDescription, GetRobotResponse, RobotState } from "../generated/virtualrobot/v1/robot_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { goal } from "../kernel/goal";
import { jogSpeed } from "../kernel/jog";
import { MOVING, TURNING } from "../kernel/leads";
import { isGone } from "../kernel/world";
import { NumberField } from "../parts/number_field";
import { fixed, unitOf } from "../parts/numbers";
import { JogButton } from "./jog_button";

/** Range of the slider of a joint without limits, rad and m. */
const TURN = Math.PI, SLIDE = 1;
const NEAR = 0.04;

interface Props {
  robot: string;
  about: GetRobotResponse;
  state: RobotState;
}

export function Joints({ robot, about, state }: Props) {
  let place = 0;
  const single = about.joints.flatMap((joint) => {
    const at = place;
    place += joint.coordinateCount;
    return joint.coordinateCount === 1 ? [{ joint, position: state.positions[at] ?? 0 }] : [];
  });
  return (
    <section aria-label="Joints">
      <h4><span>Joints{goal.shown.value?.robot === robot && <span class="ghost" title="Coloured numbers and marks are where the ghost is; the white knobs are where the robot is"> of the ghost</span>}</span></h4>
      {single.map(({ joint, position }, number) => (
        <Joint key={joint.name} robot={robot} joint={joint} number={number + 1} position={position} />
      ))}
    </section>
  );
}

interface JointProps {
  robot: string;
  joint: JointDescription;
  number: number;
  position: number;
}

function Joint({ robot, joint: { name, type, limits }, number, position }: JointProps) {
  const track = useRef<HTMLDivElement>(null);
  const slides = type === JointType.PRISMATIC;
  const { factor, unit } = unitOf(type);
  const free = slides ? SLIDE : TURN;
  const lower = limits?.lower ?? -free, upper = limits?.upper ?? free;
  const part = (value: number) => Math.max(0, Math.min(1, (value - lower) / (upper - lower || 1)));
  const at = part(position), zero = part(0);
  const wanted = goal.shown.value?.robot === robot ? goal.shown.value.jointPositions[name] : undefined;
  const speed = Math.min(slides ? MOVING : TURNING, limits?.velocity || Infinity) * jogSpeed.value;
  const jog = (sign: number) => () => ({ robot, move: { case: "jointJog" as const, value: { joint: name, velocity: sign * speed } } });
  const gone = isGone.value;
  const want = (value: number) => !gone && goal.setJoint(robot, name, Math.max(lower, Math.min(upper, value)));
  const drag = (event: PointerEvent) => {
    const area = track.current!.getBoundingClientRect();
    want(lower + ((event.clientX - area.left) / area.width) * (upper - lower));
  };
  const step = (event: KeyboardEvent) => {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (sign === undefined) return;
    event.preventDefault();
    want((wanted ?? position) + sign / factor);
  };
  const nearLimit = (limits?.lower !== undefined && at < NEAR) || (limits?.upper !== undefined && at > 1 - NEAR);
  const short = `${slides ? "P" : "J"}${number}`;
  const called = name === short ? name : `${short} ${name}`;
  return (
    <div class={`joint ${wanted === undefined ? "" : "ghostly"}`} title={name}>
      <span class="name">{short}</span>
      <JogButton label={`${called} minus`} icon="chevron-left" move={jog(-1)} />
      <div ref={track} class={`track ${nearLimit ? "near" : ""}`} role="slider" tabIndex={gone ? -1 : 0} aria-disabled={gone} aria-label={`${called}, ${unit}`}
        aria-valuemin={lower * factor} aria-valuemax={upper * factor} aria-valuenow={(wanted ?? position) * factor}
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          drag(event);
        }}
        onPointerMove={(event) => event.buttons && drag(event)} onKeyDown={step}>
        <span class="fill" style={{ left: `${100 * Math.min(at, zero)}%`, width: `${100 * Math.abs(at - zero)}%` }} />
        <span class="zero" style={{ left: `${100 * zero}%` }} />
        {wanted !== undefined && <span class="wanted" style={{ left: `${100 * part(wanted)}%` }} />}
        <span class="knob" style={{ left: `${100 * at}%` }} />
      </div>
      <JogButton label={`${called} plus`} icon="chevron-right" move={jog(1)} />
      <NumberField label={`${called} position`} about={wanted === undefined ? `Where ${called} is` : `Where the ghost has ${called}; the robot has it at ${fixed(position * factor, 1)}`} value={(wanted ?? position) * factor} unit={unit} decimals={1} write={(value) => want(value / factor)} />
    </div>
  );
}
