// Simple things to add below the tree: which, how large, where, and whether robots handle it; and what looks at them.
import { signal, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { add, addSensor, freeName, type Sensor, type Shape } from "../kernel/bodies";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { read, whyNot } from "../parts/numbers";
import { tellNumber } from "../parts/wrong_number";
import { lookingAt } from "../view/poses";

const SHAPES = [["table", "Table"], ["box", "Box"], ["cylinder", "Cylinder"], ["ball", "Ball"], ["camera", "Camera"], ["range sensor", "Range sensor"]] as const;
const SIZES: Record<Shape, readonly (readonly [name: string, label: string])[]> = {
  table: [["L", "Length along x"], ["W", "Width along y"], ["H", "Height"]],
  box: [["L", "Length along x"], ["W", "Width along y"], ["H", "Height"]],
  cylinder: [["⌀", "Diameter"], ["H", "Height"]],
  ball: [["⌀", "Diameter"]],
};
/** Millimeters. */
const FIRST: Record<Shape, readonly string[]> = { table: ["1200", "800", "750"], box: ["100", "100", "100"], cylinder: ["60", "100"], ball: ["60"] };

const isOpen = signal(false);
const shape = signal<Shape | Sensor>("table");
const name = signal("");
const sizes = signal(FIRST);
const stands = signal<readonly string[]>(["0", "0", "0"]);
const eye = signal<readonly string[]>(["1000", "-1000", "1500"]);
const aim = signal<readonly string[]>(["0", "0", "500"]);
const isPart = signal(false);
const mass = signal("0");

/** Closes the form; the next thing has a name of its own. */
function leave(): void {
  name.value = "";
  isOpen.value = false;
}

export function Adding() {
  if (!isOpen.value) {
    return (
      <div class="footer">
        <button type="button" class="button grow" title="A table, a box, a cylinder, a ball, a part, a camera, a range sensor" onClick={() => (isOpen.value = true)}><Icon name="plus" size={14} />Add …</button>
      </div>
    );
  }
  const one = shape.value;
  const body = one === "camera" || one === "range sensor" ? undefined : one;
  const size = body ? sizes.value[body] : [];
  const at = body ? stands : eye;
  const numbers = size.map(read), place = at.value.map(read), looked = aim.value.map(read), kilograms = read(mass.value);
  const handled = isPart.value && body !== undefined && one !== "table";
  const sees = looked.every((value) => value !== undefined) && looked.some((value, axis) => value !== place[axis]);
  const fits = numbers.every((value) => value !== undefined && value > 0) && place.every((value) => value !== undefined) && (!handled || (kilograms ?? -1) >= 0) && (body !== undefined || sees);
  const submit = async () => {
    if (!fits) return;
    const meters = (some: readonly (number | undefined)[]) => some.map((value) => value! / 1000);
    const [x, y, z] = meters(place), called = name.value.trim() || freeName(one);
    const done = body
      ? await add({ shape: body, name: called, size: meters(numbers), stands: [x, y, z], part: handled, mass: kilograms ?? 0 })
      : await addSensor(one as Sensor, called, lookingAt([x, y, z], meters(looked), one === "camera" ? "z" : "x"));
    if (!done) return;
    isPart.value = false;
    leave();
  };
  return (
    <form class="adding" aria-label="Add a thing" onSubmit={(event) => (event.preventDefault(), void submit())} onKeyDown={(event) => event.key === "Escape" && leave()}>
      <Choice label="What is added" options={SHAPES} chosen={one} choose={(to) => (shape.value = to)} />
      <label class="field words"><b>Name</b><input aria-label="Name of the new thing" placeholder={freeName(one)} value={name.value} onInput={(event) => (name.value = event.currentTarget.value)} /></label>
      {body && <span class="muted">Size, mm</span>}
      {body && (
        <div class="pose">
          {SIZES[body].map(([short, label], place) => (
            <Number key={label} short={short} label={label} unit="" positive text={size[place]} write={(text) => (sizes.value = { ...sizes.value, [body]: size.with(place, text) })} />
          ))}
        </div>
      )}
      <span class="muted" title={body ? "Where the middle of its underside is in the world" : "Where it is in the world"}>Stands at, mm</span>
      <Triple label="Stands at" of={at} />
      {!body && <span class="muted" title={one === "camera" ? "What is in the middle of its picture" : "Where its beam goes; in Properties it may have more beams"}>Looks at, mm</span>}
      {!body && <Triple label="Looks at" of={aim} />}
      {body && one !== "table" && (
        <div class="row">
          <button type="button" role="switch" class="switch" aria-label="Part" aria-checked={handled} title="A part is what robots pick and place" onClick={() => (isPart.value = !isPart.value)} />
          <span class="grow">Part</span>
          {handled && <Number short="m" label="Mass, 0 is unknown" unit="kg" text={mass.value} write={(text) => (mass.value = text)} />}
        </div>
      )}
      <div class="row">
        <button type="submit" class="button primary grow" disabled={!fits}><Icon name="plus" size={14} />Add it</button>
        <button type="button" class="button" title="Add nothing (Esc)" onClick={leave}><Icon name="x" size={14} /></button>
      </div>
    </form>
  );
}

function Triple({ label, of }: { label: string; of: Signal<readonly string[]> }) {
  return (
    <div class="pose">
      {["X", "Y", "Z"].map((axis, place) => (
        <Number key={axis} short={axis} label={`${label} ${axis}`} unit="" text={of.value[place]} write={(text) => (of.value = of.value.with(place, text))} />
      ))}
    </div>
  );
}

interface NumberProps {
  short: string;
  label: string;
  unit: string;
  text: string;
  positive?: boolean;
  write: (text: string) => void;
}

/** A number that counts as soon as it is written: the form takes all of them at once. */
function Number({ short, label, unit, text, positive, write }: NumberProps) {
  const whyOf = (words: string) => whyNot(words) || (positive && read(words)! <= 0 ? `${label} is more than 0` : "");
  const why = whyOf(text);
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => tellNumber.bind(undefined, field.current!, ""), []);
  return (
    <label class={`field ${why ? "wrong" : ""}`} title={why || (unit ? `${label}, ${unit}` : label)}>
      <b>{short}</b>
      <input ref={field} class="mono" aria-label={label} aria-invalid={why !== ""} inputMode="decimal" value={text} onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => {
          write(event.currentTarget.value);
          tellNumber(event.currentTarget, whyOf(event.currentTarget.value));
        }} />
      <i>{unit}</i>
    </label>
  );
}
