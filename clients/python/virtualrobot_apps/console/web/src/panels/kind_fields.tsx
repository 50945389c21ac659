// The fields of a node's kind, from the contract's descriptors: nothing here knows a kind by name.
import { ScalarType, type DescField, type DescMessage, type Message } from "@bufbuild/protobuf";
import { reflect } from "@bufbuild/protobuf/reflect";
import { NodeSchema } from "../generated/virtualrobot/v1/nodes_pb";
import { change } from "../kernel/orders";
import type { Item } from "../kernel/world";
import { NumberField } from "../parts/number_field";
import { DEGREES } from "../parts/numbers";

interface Unit {
  name: string;
  factor: number;
  decimals: number;
}

/** Units as the contract has them in the names of fields, and how people read them. */
const UNITS: [suffix: string, unit: Unit][] = [
  ["Meters", { name: "mm", factor: 1000, decimals: 1 }],
  ["Radians", { name: "°", factor: DEGREES, decimals: 2 }],
  ["Kilograms", { name: "kg", factor: 1, decimals: 3 }],
  ["Seconds", { name: "s", factor: 1, decimals: 3 }],
  ["Hertz", { name: "Hz", factor: 1, decimals: 1 }],
];
const PLAIN: Unit = { name: "", factor: 1, decimals: 3 };
const WHOLE = new Set([ScalarType.INT32, ScalarType.UINT32, ScalarType.SINT32, ScalarType.FIXED32, ScalarType.SFIXED32]);
const REAL = new Set([ScalarType.DOUBLE, ScalarType.FLOAT]);

export function KindFields({ item }: { item: Item }) {
  const { case: kind, value } = item.node.kind;
  const field = NodeSchema.fields.find(({ localName }) => localName === kind);
  if (field?.message === undefined || value === undefined) return null;
  const rows = rowsOf(field.message, value);
  if (rows.length === 0) return null;
  const write = (path: DescField[], to: unknown) =>
    void change(item.name, field.name, (node) => node.kind.case === kind && setAt(field.message!, node.kind.value!, path, to));
  return (
    <section aria-label="Settings">
      <h4>Settings</h4>
      {rows.map(({ path, value: now }) => <FieldRow key={path.map(({ name }) => name).join(".")} path={path} value={now} write={(to) => write(path, to)} />)}
    </section>
  );
}

interface Row {
  path: DescField[];
  value: unknown;
}

/** Returns the fields of one value, those of messages within as well. */
function rowsOf(schema: DescMessage, message: Message, before: DescField[] = []): Row[] {
  const reflected = reflect(schema, message);
  return schema.fields.flatMap((field) => {
    const path = [...before, field];
    if (field.fieldKind === "scalar" || field.fieldKind === "enum") return [{ path, value: reflected.get(field) }];
    if (field.fieldKind !== "message" || !reflected.isSet(field) || path.length > 2) return [];
    return field.message.typeName.startsWith("virtualrobot.") ? rowsOf(field.message, reflected.get(field).message, path) : [];
  });
}

function setAt(schema: DescMessage, message: Message, [field, ...rest]: DescField[], to: unknown): void {
  const reflected = reflect(schema, message);
  if (rest.length > 0 && field.fieldKind === "message") setAt(field.message, reflected.get(field).message, rest, to);
  else reflected.set(field, to as never);
}

function FieldRow({ path, value, write }: Row & { write: (to: unknown) => void }) {
  const field = path.at(-1)!;
  const { unit, label } = named(path);
  if (field.fieldKind === "enum") {
    return (
      <label class="property">
        <span>{label}</span>
        <select class="select" value={String(value)} onChange={(event) => write(Number(event.currentTarget.value))}>
          {field.enum.values.map(({ number, localName }) => <option key={number} value={number}>{localName.toLowerCase().replaceAll("_", " ")}</option>)}
        </select>
      </label>
    );
  }
  const scalar = field.scalar!;
  if (scalar === ScalarType.BOOL) {
    return (
      <div class="property">
        <span>{label}</span>
        <button type="button" role="switch" class="switch" aria-label={label} aria-checked={value === true} onClick={() => write(!value)} />
      </div>
    );
  }
  if (REAL.has(scalar) || WHOLE.has(scalar)) {
    const whole = WHOLE.has(scalar);
    return (
      <div class="property">
        <span>{label}</span>
        <NumberField label={label} value={Number(value ?? 0) * unit.factor} unit={unit.name} decimals={whole ? 0 : unit.decimals}
          write={(to) => write(whole ? Math.round(to) : to / unit.factor)} />
      </div>
    );
  }
  if (scalar !== ScalarType.STRING || value === "") return null;
  return <div class="property"><span>{label}</span><span class="cut" title={String(value)}>{String(value)}</span></div>;
}

function named(path: DescField[]): { unit: Unit; label: string } {
  const name = path.map(({ localName }) => localName).join(" ");
  const [suffix, unit] = UNITS.find(([one]) => name.endsWith(one)) ?? ["", PLAIN];
  const text = name.slice(0, name.length - suffix.length).replace(/[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`);
  return { unit, label: text[0].toUpperCase() + text.slice(1) };
}
