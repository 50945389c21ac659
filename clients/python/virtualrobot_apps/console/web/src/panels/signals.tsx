// Signals of the cell: what they are, set by hand; what connects them; and when they changed.
import { useEffect, useState } from "preact/hooks";
import type { Signal, SignalValue } from "../generated/virtualrobot/v1/signal_pb";
import { connections, look } from "../kernel/connections";
import { createSignal, removeSignal, setSignal } from "../kernel/orders";
import { signalsPart as part } from "../kernel/shown";
import { cellSignals } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { Connections } from "./connections";
import { Timing } from "./timing";

const LOOK_MS = 700;
const FIRST: Record<string, SignalValue["kind"]> = {
  boolean: { case: "boolean", value: false },
  integer: { case: "integer", value: 0n },
  number: { case: "number", value: 0 },
  text: { case: "text", value: "" },
};

const PARTS = [["values", "Values"], ["connections", "Connections"], ["timing", "Timing"]] as const;

export function Signals() {
  useEffect(() => {
    void look();
    const timer = setInterval(() => void look(), LOOK_MS);
    return () => clearInterval(timer);
  }, []);
  const choice = <Choice label="Part" options={PARTS} chosen={part.value} choose={(one) => (part.value = one)} />;
  if (part.value === "connections") return <Connections choice={choice} />;
  if (part.value === "timing") return <Timing choice={choice} />;
  const driven = new Set(connections().map(([target]) => target));
  return (
    <>
      <div class="list signals" role="list" aria-label="Signals">
        {cellSignals.value.size === 0 && <p class="hint">This cell has no signals. Make one below.</p>}
        {[...cellSignals.value.values()].map((one) => (
          <div key={one.name} class="entry" role="listitem" aria-label={`Signal ${one.name}`} title={one.description}>
            <Value signal={one} />
            <span class="mono cut">{one.name}</span>
            {driven.has(one.name) && <span title="A connection of this console drives it"><Icon name="cable" size={13} color="var(--accent)" /></span>}
            <span class="muted grow cut">{one.description}</span>
            <span class="acts">
              <button type="button" class="tool small" title={`Remove the signal ${one.name}`} onClick={() => void removeSignal(one.name)}><Icon name="trash-2" size={13} /></button>
            </span>
          </div>
        ))}
      </div>
      <div class="under program-bar">
        {choice}
        <span class="grow" />
        <Make />
      </div>
    </>
  );
}

function Make() {
  const [name, setName] = useState("");
  const [kind, setKind] = useState("boolean");
  const make = async () => {
    if (await createSignal(name.trim(), FIRST[kind])) setName("");
  };
  return (
    <form class="row" onSubmit={(event) => (event.preventDefault(), void make())}>
      <label class="field words"><input aria-label="Name of the new signal" placeholder="new signal" value={name} onInput={(event) => setName(event.currentTarget.value)} /></label>
      <select class="select add-kind" aria-label="Type of the new signal" title="Its type stays" value={kind} onChange={(event) => setKind(event.currentTarget.value)}>
        {Object.keys(FIRST).map((one) => <option key={one}>{one}</option>)}
      </select>
      <button type="submit" class="button small" disabled={name.trim() === ""}><Icon name="plus" size={13} />Make</button>
    </form>
  );
}

export function Value({ signal: { name, value, unit } }: { signal: Signal }) {
  const kind = value?.kind;
  switch (kind?.case) {
    case "boolean":
      return (
        <button type="button" role="switch" class="switch" aria-label={name} aria-checked={kind.value} title={`${name}: ${kind.value ? "on" : "off"}`}
          onClick={() => void setSignal(name, { case: "boolean", value: !kind.value })} />
      );
    case "integer":
      return <NumberField label={name} value={Number(kind.value)} unit={unit} decimals={0} write={(to) => void setSignal(name, { case: "integer", value: BigInt(Math.round(to)) })} />;
    case "number":
      return <NumberField label={name} value={kind.value} unit={unit} decimals={3} write={(to) => void setSignal(name, { case: "number", value: to })} />;
    case "text":
      return <Words name={name} value={kind.value} />;
    case "group": {
      const { values } = kind.value;
      const turned = (bit: number) => values.map((on, place) => (place === bit ? !on : on));
      return (
        <span class="bits" role="group" aria-label={name}>
          {values.map((on, bit) => (
            <button key={bit} type="button" class="mono bit" role="switch" aria-checked={on} aria-label={`${name}, bit ${bit}`} title={`Bit ${bit}`}
              onClick={() => void setSignal(name, { case: "group", value: { $typeName: "virtualrobot.v1.BooleanGroup", values: turned(bit) } })}>
              {on ? "1" : "0"}
            </button>
          ))}
        </span>
      );
    }
    default:
      return null;
  }
}

/** A text that is set by Enter, and stays as it was after Esc. */
function Words({ name, value }: { name: string; value: string }) {
  const [text, setText] = useState<string | undefined>(undefined);
  return (
    <label class="field words" title={`${name}; Enter sets it`}>
      <input aria-label={name} value={text ?? value} onInput={(event) => setText(event.currentTarget.value)} onBlur={() => setText(undefined)}
        onKeyDown={(event) => {
          if (event.key === "Enter" && text !== undefined) void setSignal(name, { case: "text", value: text });
          if (event.key === "Enter" || event.key === "Escape") event.currentTarget.blur();
        }} />
    </label>
  );
}
