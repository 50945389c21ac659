// Gamepad, space mouse and keyboard: which of them are there, what is held, and the files that say what they mean.
import { useEffect, useRef } from "preact/hooks";
import { gamepad, isCraft, keys, readDevices, spaceMouse, type Mapping } from "../kernel/devices";
import { keyboard } from "../kernel/keyboard";
import { opened, toggle } from "../kernel/shown";
import { mouse } from "../kernel/space_mouse";
import { chosen } from "../kernel/world";
import { Icon } from "../parts/icons";
import { viewport } from "./view";

const KINDS = [
  { one: gamepad, name: "Gamepad", absent: "press one of its buttons" },
  { one: spaceMouse, name: "Space mouse", absent: mouse.isPossible ? "connect it" : isSecureContext ? "browsers of the Chromium family know them" : "browsers know them only by https" },
  { one: keys, name: "Keyboard", absent: "it moves no robot" },
];

/** Whether the pendant is shown, whose robot devices lead. */
let hasPendant = false;

/** Opens what there is to say of devices; they lead robots as long as the pendant is shown. */
export function DevicesButton() {
  useEffect(() => {
    hasPendant = true;
    return () => void (hasPendant = false);
  }, []);
  const some = KINDS.some(({ one }) => one.name.value);
  return (
    <button type="button" class="tool" aria-pressed={opened.value === "devices"} title="Gamepad and space mouse" onClick={() => toggle("devices")}>
      <Icon name="gamepad-2" size={17} color={some ? "var(--accent)" : undefined} />
    </button>
  );
}

/** Tells what has to be held, of each device that is there. */
export function DevicesHeld() {
  return (
    <>
      {KINDS.map(({ one, name }) => one.name.value && one.mapping.value && (
        <p key={name} class="hint cut" title={`${one.name.value} moves ${chosen.value} while its button is held`}>
          <Icon name="gamepad-2" size={13} /> {one.name.value}: hold {one.mapping.value.hold.replaceAll("_", " ")}
        </p>
      ))}
    </>
  );
}

export function Devices() {
  useEffect(() => readDevices(
    () => (hasPendant ? chosen.peek() : ""),
    (parts, seconds) => viewport.current?.observer.steer(parts, seconds),
  ), []);
  if (opened.value !== "devices") return null;
  return (
    <section class="float over wide" aria-label="Gamepad and space mouse" onKeyDown={(event) => event.key === "Escape" && (opened.value = "")}>
      <div class="row"><b class="grow">Gamepad and space mouse</b><button type="button" class="tool small" title="Close" onClick={() => (opened.value = "")}><Icon name="x" size={14} /></button></div>
      <p class="hint">{chosen.value || "A robot"} moves while the dead man's button is held and the pendant is shown; the view may, whatever is shown.</p>
      {KINDS.map((kind) => <Kind key={kind.name} {...kind} />)}
    </section>
  );
}

function Kind({ one, name, absent }: (typeof KINDS)[number]) {
  const field = useRef<HTMLInputElement>(null);
  const mapping = one.mapping.value;
  return (
    <section aria-label={name}>
      <div class="row">
        <b>{name}</b>
        <span class="grow cut muted" role="status" title={one.name.value}>{one.name.value || `none: ${absent}`}</span>
        {one === spaceMouse && mouse.isPossible && !one.name.value && (
          <button type="button" class="button small" title="The browser asks which one" onClick={() => void mouse.choose()}>Connect</button>
        )}
      </div>
      {mapping && <p class="hint">{words(mapping)} {mapping.slower || mapping.faster ? `Speed ${Math.round(100 * one.share.value)} % (${[mapping.slower, mapping.faster].filter(Boolean).join(", ")}).` : ""}</p>}
      <div class="row">
        <input ref={field} type="file" hidden aria-label={`Mapping of the ${name.toLowerCase()} to open`} accept=".yaml,.yml"
          onChange={(event) => {
            const [file] = event.currentTarget.files ?? [];
            event.currentTarget.value = "";
            if (file) void one.read(file);
          }} />
        <span class="grow cut muted" title="What axes and buttons mean">{one.file.value || "usual mapping"}</span>
        {one === keys && (
          <button type="button" class="button small" aria-pressed={!!one.name.value} onClick={() => (keyboard.isUsed = !keyboard.isUsed)}>{one.name.value ? "Let it be" : "Use it"}</button>
        )}
        {(one.file.value || (one.name.value && !mapping)) && <button type="button" class="button small" onClick={() => void one.read()}>Usual one</button>}
        <button type="button" class="button small" title="A mapping file, as virtualrobot teleop --mapping takes it" onClick={() => field.current?.click()}><Icon name="folder-open" size={13} />Mapping</button>
      </div>
    </section>
  );
}

/** Says what a mapping moves of the chosen robot. */
function words({ hold, drive, tool, jog, frame, camera }: Mapping): string {
  const moved = isCraft(chosen.value) ? drive : Object.keys(tool).length > 0 ? tool : jog;
  const what = moved === drive ? "the craft" : moved === tool ? `the tool, along the axes of ${frame}` : "joints";
  const each = Object.entries(moved).map(([name, { axis, sign, buttons }]) => `${/^\d+$/.test(name) ? `J${name}` : name} ${axis ? `${sign < 0 ? "−" : ""}${axis}` : buttons.join("/")}`);
  const looks = Object.keys(camera).length > 0 ? " Without it the view moves." : "";
  return `Hold ${hold}: ${what}: ${each.join(", ") || "nothing"}.${looks}`;
}
