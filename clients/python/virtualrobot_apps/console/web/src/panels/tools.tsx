// Tools of a robot: their states, and how wide they are open.
import type { RobotState } from "../generated/virtualrobot/v1/robot_pb";
import { run } from "../kernel/orders";
import { items, selected } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { fixed } from "../parts/numbers";

export function Tools({ robot, state }: { robot: string; state: RobotState }) {
  const names = Object.keys(state.toolStates);
  if (names.length === 0) return null;
  return (
    <section aria-label="Tools">
      <h4>Tools</h4>
      {names.map((name) => {
        const kind = items.value.get(name)?.node.kind;
        const states = kind?.case === "tool" ? kind.value.states.map((one) => one.name) : [];
        const width = state.toolWidths[name];
        return (
          <div key={name} class="row">
            <Icon name="tool" size={15} color="var(--tool)" />
            <button type="button" class="grow link" onClick={() => (selected.value = name)}>{name}</button>
            {width !== undefined && <span class="mono muted">{fixed(1000 * width, 1)} mm</span>}
            {states.length > 0 && (
              <Choice label={`State of ${name}`} options={states.map((one) => [one, one] as const)} chosen={state.toolStates[name]}
                choose={(one) => void run({ moves: [{ robot, move: { case: "toolState", value: { tool: name, state: one } } }] })} />
            )}
          </div>
        );
      })}
    </section>
  );
}
