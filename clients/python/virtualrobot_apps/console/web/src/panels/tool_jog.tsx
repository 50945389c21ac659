// Jogs of the tool centre point along and about axes of the base, the tool or the world.
import { signal } from "@preact/signals";
import { JogFrame } from "../generated/virtualrobot/v1/motion_pb";
import { jogSpeed, type Move } from "../kernel/jog";
import { Choice } from "../parts/choice";
import { JogButton } from "./jog_button";
import { JogSpeed } from "./pendant";

const FRAMES = { base: JogFrame.BASE, tool: JogFrame.TOOL, world: JogFrame.NODE };
const AXES = ["X", "Y", "Z", "RX", "RY", "RZ"];
const COLORS = ["var(--x)", "var(--y)", "var(--z)"];
/** Greatest speeds: m/s and rad/s. */
const MOVING = 0.25, TURNING = 0.8;

const frame = signal<keyof typeof FRAMES>("base");

export function ToolJog({ robot }: { robot: string }) {
  return (
    <section aria-label="Tool centre point">
      <h4>
        Tool centre point
        <Choice label="Axes" options={[["base", "Base"], ["tool", "Tool"], ["world", "World"]]} chosen={frame.value} choose={(one) => (frame.value = one)} />
      </h4>
      <div class="axes">
        {AXES.map((axis, place) => (
          <div key={axis} class="axis">
            <JogButton label={`${axis} plus`} icon="plus" move={() => jog(robot, place, 1)} />
            <span style={{ color: COLORS[place % 3] }}>{axis}</span>
            <JogButton label={`${axis} minus`} icon="minus" move={() => jog(robot, place, -1)} />
          </div>
        ))}
      </div>
      <JogSpeed />
    </section>
  );
}

function jog(robot: string, place: number, sign: number): Move {
  const value = { x: 0, y: 0, z: 0, ["xyz"[place % 3]]: sign };
  const turns = place >= 3;
  const direction = turns ? { case: "rotation" as const, value } : { case: "translation" as const, value };
  const velocity = (turns ? TURNING : MOVING) * jogSpeed.value;
  return { robot, move: { case: "cartesianJog", value: { direction, frame: FRAMES[frame.value], velocity } } };
}
