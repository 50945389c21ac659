// Connections: which signals become which others, by what logic; made, changed and removed while they run.
import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import type { JsonObject, JsonValue } from "@bufbuild/protobuf";
import { connect, connections, disconnect, open, operandOf, setRunning, text, wiring, type Operator } from "../kernel/connections";
import { download } from "../kernel/loader";
import { attempt, say } from "../kernel/messages";
import { cellSignals } from "../kernel/world";
import { Icon } from "../parts/icons";
import { read, whyNot } from "../parts/numbers";
import { tellNumber } from "../parts/wrong_number";
import { Value } from "./signals";

const MANY = "...";
const SAME: Operator = { name: "is", about: "the same as", inputs: ["input"], optional: [], settings: [] };
const WORDS: Operator = { name: "text", about: "these words", inputs: ["words"], optional: [], settings: [] };

/** What is about to be connected, as it is written in the fields. */
const form = signal({ target: "", operator: "and", inputs: ["", ""], setting: "" });

export function Connections({ choice }: { choice: ComponentChildren }) {
  const some = connections();
  const { fault = "", said = [], file } = wiring.value ?? {};
  const devices = [...((file?.tools ?? []) as JsonObject[]), ...((file?.belts ?? []) as JsonObject[])];
  return (
    <>
      <div class="list connections" role="list" aria-label="Connections">
        {fault && <p class="hint warned" role="alert"><Icon name="triangle-alert" size={14} />They have ended: {fault}</p>}
        {said.map((line) => <p key={line} class="hint warned"><Icon name="triangle-alert" size={14} />{line}</p>)}
        {some.length === 0 && devices.length === 0 && (
          <p class="hint">No signal is connected by this console. Choose one below, what it shall be, and of which signals; or open a file of connections.</p>
        )}
        {some.map(([target, source]) => <Row key={target} target={target} source={source} />)}
        {devices.map((one, place) => (
          <div key={place} class="entry" role="listitem">
            <Icon name={"joint" in one ? "move-horizontal" : "tool"} size={14} color="var(--tool)" />
            <b class="cut">{String(one.robot)}</b>
            <span class="muted grow cut">{"joint" in one ? `${String(one.joint)} runs` : `${String(one.on)}, else ${String(one.off)},`} while <span class="mono">{String(one.signal)}</span> is on</span>
          </div>
        ))}
      </div>
      <Bar choice={choice} isAny={some.length > 0 || devices.length > 0} />
    </>
  );
}

function Row({ target, source }: { target: string; source: JsonValue }) {
  const driven = cellSignals.value.get(target);
  return (
    <div class="entry" role="listitem" aria-label={`Connection of ${target}`}>
      <span class="state">{driven && <Value signal={driven} />}</span>
      <b class="mono">{target}</b>
      <span class="muted">=</span>
      <span class="grow cut"><Expression source={source} /></span>
      <span class="acts">
        <button type="button" class="tool small" title={`Change the connection of ${target}`} onClick={() => edit(target, source)}><Icon name="pencil" size={13} /></button>
        <button type="button" class="tool small" title={`Remove the connection of ${target}; the signal stays as it is`} onClick={() => void disconnect(target)}><Icon name="trash-2" size={13} /></button>
      </span>
    </div>
  );
}

/** Shows what gives a value; signals that are on are lit. */
function Expression({ source }: { source: JsonValue }) {
  if (typeof source === "string") {
    const kind = cellSignals.value.get(source)?.value?.kind;
    const isOn = kind?.case === "boolean" && kind.value;
    return <span class={`mono ${isOn ? "good" : ""}`} data-on={isOn}>{source}</span>;
  }
  if (typeof source !== "object" || source === null || Array.isArray(source)) return <span class="mono">{source === true ? "on" : source === false ? "off" : String(source)}</span>;
  const [[operator, about]] = Object.entries(source);
  if (operator === "text") return <span class="mono">“{String(about)}”</span>;
  const fields = Array.isArray(about) ? about.map((one) => ["", one] as const) : isNamed(operator, about) ? Object.entries(about as JsonObject) : ([["", about]] as const);
  const setting = fields.find(([name]) => name === "seconds" || name === "index");
  const inputs = fields.filter((one) => one !== setting);
  return (
    <>
      <span class="accent">{operator.replaceAll("_", " ")}</span>
      {setting && <span class="mono muted"> {String(setting[1])}{setting[0] === "seconds" ? " s" : ""}</span>}
      <span class="muted"> (</span>
      {inputs.map(([name, one], place) => (
        <span key={place}>{place > 0 && <span class="muted">, </span>}{name && inputs.length > 1 && <span class="muted">{name} </span>}<Expression source={one} /></span>
      ))}
      <span class="muted">)</span>
    </>
  );
}

/** Whether what an operator works on are fields, and not one expression. */
function isNamed(name: string, about: JsonValue): boolean {
  const made = wiring.value?.operators.find((one) => one.name === name);
  const plain = made?.inputs.length === 1 && made.settings.length === 0;
  return typeof about === "object" && about !== null && !plain;
}

function Bar({ choice, isAny }: { choice: ComponentChildren; isAny: boolean }) {
  const { target, operator, inputs, setting } = form.value;
  const operators = [SAME, ...(wiring.value?.operators ?? []), WORDS];
  const made = operators.find(({ name }) => name === operator) ?? SAME;
  const field = useRef<HTMLInputElement>(null);
  const names = made.inputs[0] === MANY ? inputs.map((_, place) => `signal ${place + 1}`) : made.inputs;
  const write = (place: number, words: string) => (form.value = { ...form.value, inputs: inputs.with(place, words) });
  const choose = (name: string) => {
    const { inputs: wanted } = operators.find((one) => one.name === name)!;
    const count = wanted[0] === MANY ? Math.max(2, inputs.length) : wanted.length;
    form.value = { ...form.value, operator: name, setting: "", inputs: Array.from({ length: count }, (_, place) => inputs[place] ?? "") };
  };
  return (
    <form class="under program-bar wraps" onSubmit={(event) => (event.preventDefault(), void add(made))}>
      {choice}
      <select class="select target" aria-label="Signal to drive" title="The signal that is driven" value={target} onChange={(event) => (form.value = { ...form.value, target: event.currentTarget.value })}>
        <option value="">signal …</option>
        {[...cellSignals.value.keys()].map((name) => <option key={name}>{name}</option>)}
      </select>
      <span class="muted">=</span>
      <select class="select" aria-label="Logic" title={made.about} value={operator} onChange={(event) => choose(event.currentTarget.value)}>
        {operators.map(({ name, about }) => <option key={name} value={name} title={about}>{name.replaceAll("_", " ")}</option>)}
      </select>
      {names.map((name, place) => (
        <label key={place} class="field words" title={`${name}${made.optional.includes(name) ? ", may be left out" : ""}: a signal, not and a signal, a number, on or off`}>
          <input list="signal-names" aria-label={`Input ${name}`} placeholder={name} value={inputs[place] ?? ""} onInput={(event) => write(place, event.currentTarget.value)} />
        </label>
      ))}
      {made.inputs[0] === MANY && <button type="button" class="tool small" title="One more signal" onClick={() => (form.value = { ...form.value, inputs: [...inputs, ""] })}><Icon name="plus" size={13} /></button>}
      {made.settings.map((name) => (
        <label key={name} class={`field setting ${setting && read(setting) === undefined ? "wrong" : ""}`} title={name === "seconds" ? "Simulation time, s" : "Which bit, from 0"}>
          <input class="mono" inputMode="decimal" aria-label={name} placeholder={name === "seconds" ? "time" : name} value={setting}
            onInput={(event) => {
              form.value = { ...form.value, setting: event.currentTarget.value };
              tellNumber(event.currentTarget, event.currentTarget.value && whyNot(event.currentTarget.value));
            }} />
          <i>{name === "seconds" ? "s" : ""}</i>
        </label>
      ))}
      <datalist id="signal-names">{[...cellSignals.value.keys()].map((name) => <option key={name} value={name} />)}</datalist>
      <button type="submit" class="button small" disabled={!target} title="Check it, and run it from now on"><Icon name="cable" size={13} />Connect</button>
      <span class="grow" />
      <input ref={field} type="file" accept=".yaml,.yml" hidden id="open-connections" aria-label="File of connections to open" onChange={(event) => {
        const [file] = event.currentTarget.files ?? [];
        event.currentTarget.value = "";
        if (file) void attempt(open(file));
      }} />
      <button type="button" class="tool small" title="Open a file of connections in place of these" onClick={() => field.current?.click()}><Icon name="folder-open" size={14} /></button>
      <button type="button" class="tool small" id="save-connections" disabled={!isAny} title="Save as a file, for virtualrobot connections" onClick={() => download(new Blob([text()], { type: "application/yaml" }), wiring.peek()?.name ?? "connections.yaml")}><Icon name="save" size={14} /></button>
      <button type="button" class="tool small" disabled={!isAny} title={wiring.value?.running ? "Let them rest; signals stay as they are" : "Run them again"} onClick={() => void setRunning(!wiring.peek()?.running)}><Icon name={wiring.value?.running ? "pause" : "play"} size={14} /></button>
      <span class={`mono ${isAny && wiring.value?.running ? "good" : "muted"}`} id="connections-state">{isAny && wiring.value?.running ? "running" : "at rest"}</span>
    </form>
  );
}

async function add(made: Operator): Promise<void> {
  const { target, operator, inputs, setting } = form.peek();
  const source = sourceOf(made, inputs, setting);
  if (source === undefined) return;
  if (await connect(target, source)) form.value = { target: "", operator, inputs: inputs.map(() => ""), setting: "" };
}

/** Returns what the fields say as files do; undefined, and a message, where something is missing. */
function sourceOf(made: Operator, inputs: readonly string[], setting: string): JsonValue | undefined {
  if (made === WORDS) return { text: inputs[0] };
  const names = made.inputs[0] === MANY ? inputs.map((_, place) => String(place)) : made.inputs;
  const found = new Map<string, JsonValue>();
  for (const [place, name] of names.entries()) {
    const operand = operandOf(inputs[place] ?? "");
    if (operand !== undefined) found.set(name, operand);
    else if (made.inputs[0] !== MANY && !made.optional.includes(name)) return missing(`${made.name} needs ${name === "input" ? "a signal" : `'${name}'`}`);
  }
  if (made === SAME) return found.get("input");
  const [named] = made.settings;
  const number = named ? read(setting) : undefined;
  if (named && number === undefined) return missing(`${made.name} needs ${named === "seconds" ? "a time in seconds" : named}, not ${JSON.stringify(setting)}`);
  const values = [...found.values()];
  if (made.inputs[0] === MANY || made.inputs.join() === "a,b") return { [made.name]: values };
  if (made.inputs.length === 1 && !named) return { [made.name]: values[0] };
  return { [made.name]: { ...Object.fromEntries(found), ...(named ? { [named]: number! } : {}) } };
}

function missing(words: string): undefined {
  say(words, "error");
  return undefined;
}

/** Writes a connection into the fields, to be changed; what is nested stays in files. */
function edit(target: string, source: JsonValue): void {
  const put = (operator: string, inputs: JsonValue[], setting = "") => (form.value = { target, operator, inputs: inputs.map(words), setting });
  if (typeof source !== "object" || source === null || Array.isArray(source)) return void put("is", [source]);
  const [[operator, about]] = Object.entries(source);
  if (Array.isArray(about)) return void put(operator, about);
  if (!isNamed(operator, about)) return void put(operator, [about]);
  const fields = about as JsonObject;
  const made = wiring.peek()?.operators.find(({ name }) => name === operator);
  put(operator, (made?.inputs ?? []).map((name) => fields[name] ?? ""), String(fields.seconds ?? fields.index ?? ""));
}

function words(source: JsonValue): string {
  if (typeof source !== "object" || source === null) return source === true ? "on" : source === false ? "off" : String(source);
  if (!Array.isArray(source) && "not" in source) return `not ${words(source.not)}`;
  say("what is nested can be changed in its file alone", "warning");
  return "";
}
