// Buttons that show the cell in a room, why there are none, and what goes on there for those who stand beside.
import { able, why, type Mode } from "../xr/support";
import { enter, entered } from "../xr/session";
import { cssOf, look } from "../xr/looks";
import { change, settings } from "../xr/observer";
import { scale, sizeWords } from "../xr/scale";
import { kept } from "../kernel/viewpoints";
import { viewers } from "../kernel/viewers";
import { Icon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { companion } from "../view/spectator";
import { Invitation } from "./invitation";
import { Phone } from "./phone";
import { viewport } from "./view";

const ABOUT: Record<Mode, readonly [name: string, icon: string, title: string]> = {
  "immersive-ar": ["Augmented reality", "scan-eye", "Augmented reality: the cell in the room where you are"],
  "immersive-vr": ["Virtual reality", "rectangle-goggles", "Virtual reality: stand in the cell"],
};

/** The buttons over the view, of what this browser can. */
export function RoomTools() {
  return (
    <>
      {able.value.map((mode) => (
        <button key={mode} type="button" class="tool" aria-pressed={entered.value?.mode === mode} title={ABOUT[mode][2]} onClick={() => begin(mode)}>
          <Icon name={ABOUT[mode][1]} size={17} />
        </button>
      ))}
    </>
  );
}

/** The same with words, or the reason why there is nothing to press. */
export function RoomSection() {
  return (
    <section aria-label="In the room">
      <h4>In the room</h4>
      <div class="row">
        {able.value.map((mode) => (
          <button key={mode} type="button" class="button grow" title={ABOUT[mode][2]} onClick={() => begin(mode)}><Icon name={ABOUT[mode][1]} size={14} />{ABOUT[mode][0]}</button>
        ))}
      </div>
      {why.value && <p class="hint">{why.value}.</p>}
      {able.value.length > 0 && <Observer />}
      <Others />
      <Phone />
      <Invitation />
    </section>
  );
}

/** How the cell is shown in the room, and from where it is seen at first. */
function Observer() {
  const { near, far, pose, height, speed } = settings.value;
  return (
    <>
      <div class="property">
        <span>Seen from, to</span>
        <NumberField label="Near: nothing is seen before, 0.01 to 1" value={near} unit="m" decimals={2} write={(to) => change({ near: to })} />
        <NumberField label="Far: nothing is seen behind, 2 to 1000" value={far} unit="m" decimals={0} write={(to) => change({ far: to })} />
      </div>
      <div class="property">
        <span>Eyes, walking</span>
        <NumberField label="Height of the eyes in virtual reality, 0 for your own" value={height} unit="m" decimals={2} write={(to) => change({ height: to })} />
        <NumberField label="Speed by the stick, 0.1 to 10" value={speed} unit="m/s" decimals={1} write={(to) => change({ speed: to })} />
      </div>
      <label class="property">
        <span>Enters</span>
        <select class="select" aria-label="Where you stand at first" value={kept.value.some(({ name }) => name === pose) ? pose : ""} onChange={(event) => change({ pose: event.currentTarget.value })}>
          <option value="">before the robot</option>
          {kept.value.map(({ name }) => <option key={name} value={name}>{name}</option>)}
        </select>
      </label>
    </>
  );
}

/** Who else is in the room: with whose eyes this page may look, as a second screen. */
function Others() {
  return (
    <>
      {viewers.value.map(({ id, name }) => (
        <div key={id} class="row">
          <span class="cut grow">{name || id}</span>
          <button type="button" class="chip" aria-pressed={companion.value === id} title="See what they see: a second screen" onClick={() => (companion.value = companion.value === id ? "" : id)}>Look along</button>
        </div>
      ))}
    </>
  );
}

/** Says what whoever is in the room sees on the panel there. */
export function InRoom() {
  const room = entered.value;
  if (!room) return null;
  return (
    <div class="float alone" role="status" id="room">
      <Icon name={ABOUT[room.mode][1]} size={16} color={cssOf(look.value.color)} />
      <span class="cut"><b>{look.value.title}</b> {look.value.words}{scale.value !== 1 && ` · ${sizeWords(scale.value)}`}</span>
      <button type="button" class="button small" title={`Leave ${ABOUT[room.mode][0].toLowerCase()}`} onClick={() => room.leave()}>Leave</button>
    </div>
  );
}

function begin(mode: Mode): void {
  if (viewport.current) void enter(viewport.current, mode);
}
