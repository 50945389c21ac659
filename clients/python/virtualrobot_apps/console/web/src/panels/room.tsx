// Buttons that show the cell in a room, why there are none, and what goes on there for those who stand beside.
import { able, why, type Mode } from "../xr/support";
import { enter, entered } from "../xr/session";
import { cssOf, look } from "../xr/looks";
import { scale, sizeWords } from "../xr/scale";
import { Icon } from "../parts/icons";
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
      <Phone />
      <Invitation />
    </section>
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
