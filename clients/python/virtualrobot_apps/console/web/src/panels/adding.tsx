// Simple things to add below the tree: which, how large, where, and whether robots handle it.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { add, freeName, type Shape } from "../kernel/bodies";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { read, whyNot } from "../parts/numbers";
import { tellNumber } from "../parts/wrong_number";

const SHAPES = [["table", "Table"], ["box", "Box"], ["cylinder", "Cylinder"], ["ball", "Ball"]] as const;
const SIZES: Record<Shape, readonly (readonly [name: string, label: string])[]> = {
  table: [["L", "Length along x"], ["W", "Width along y"], ["H", "Height"]],
  box: [["L", "Length along x"], ["W", "Width along y"], ["H", "Height"]],
  cylinder: [["⌀", "Diameter"], ["H", "Height"]],
  ball: [["⌀", "Diameter"]],
};
/** Millimeters. */
const FIRST: Record<Shape, readonly string[]> = { table: ["1200", "800", "750"], box: ["100", "100", "100"], cylinder: ["60", "100"], ball: ["60"] };

const isOpen = signal(false);
const shape = signal<Shape>("table");
const name = signal("");
const sizes = signal(FIRST);
const stands = signal<readonly string[]>(["0", "0", "0"]);
const isPart = signal(false);
const mass = signal("0");

export function Adding() {
  if (!isOpen.value) {
    return (
      <div class="footer">
        <button type="button" class="button grow" title="A table, a box, a cylinder, a ball, a part" onClick={() => (isOpen.value = true)}><Icon name="plus" size={14} />Add …</button>
      </div>
    );
  }
  const one = shape.value, size = sizes.value[one];
  const numbers = size.map(read), place = stands.value.map(read), kilograms = read(mass.value);
  const handled = isPart.value && one !== "table";
  const fits = numbers.every((value) => value !== undefined && value > 0) && place.every((value) => value !== undefined) && (!handled || (kilograms ?? -1) >= 0);
  const submit = async () => {
    const [x, y, z] = place.map((value) => value! / 1000);
    const done = fits && (await add({ shape: one, name: name.value.trim() || freeName(one), size: numbers.map((value) => value! / 1000), stands: [x, y, z], part: handled, mass: kilograms ?? 0 }));
    if (!done) return;
    name.value = "";
    isOpen.value = isPart.value = false;
  };
  return (
    <form class="adding" aria-label="Add a thing" onSubmit={(event) => (event.preventDefault(), void submit())} onKeyDown={(event) => event.key === "Escape" && (isOpen.value = false)}>
      <Choice label="What is added" options={SHAPES} chosen={one} choose={(to) => (shape.value = to)} />
      <label class="field words"><b>Name</b><input aria-label="Name of the new thing" placeholder={freeName(one)} value={name.value} onInput={(event) => (name.value = event.currentTarget.value)} /></label>
      <span class="muted">Size, mm</span>
      <div class="pose">
        {SIZES[one].map(([short, label], at) => (
          <Number key={label} short={short} label={label} unit="" positive text={size[at]} write={(text) => (sizes.value = { ...sizes.value, [one]: size.with(at, text) })} />
        ))}
      </div>
      <span class="muted" title="Where the middle of its underside is in the world">Stands at, mm</span>
      <div class="pose">
        {["X", "Y", "Z"].map((axis, at) => (
          <Number key={axis} short={axis} label={`Stands at ${axis}`} unit="" text={stands.value[at]} write={(text) => (stands.value = stands.value.with(at, text))} />
        ))}
      </div>
      {one !== "table" && (
        <div class="row">
          <button type="button" role="switch" class="switch" aria-label="Part" aria-checked={handled} title="A part is what robots pick and place" onClick={() => (isPart.value = !isPart.value)} />
          <span class="grow">Part</span>
          {handled && <Number short="m" label="Mass, 0 is unknown" unit="kg" text={mass.value} write={(text) => (mass.value = text)} />}
        </div>
      )}
      <div class="row">
        <button type="submit" class="button primary grow" disabled={!fits}><Icon name="plus" size={14} />Add it</button>
        <button type="button" class="button" title="Add nothing (Esc)" onClick={() => (isOpen.value = false)}><Icon name="x" size={14} /></button>
      </div>
    </form>
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
