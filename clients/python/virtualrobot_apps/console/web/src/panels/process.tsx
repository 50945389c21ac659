// A process: its file as a text, edges that are clicked, reach and collisions along its ways in colours, its tolerance, plan and run.
import { effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import {
  begin, busy, canRun, change, fault, listNames, look, looks, names, open, pick, picked, plan, planIt, run, said, text, write, type Field, type State,
} from "../kernel/process";
import { running } from "../kernel/program";
import { Icon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { leave, take as takeClicks } from "../view/aiming";
import { featureAim, placeAt } from "../view/finding";
import { showSpans, type Span } from "../view/spans";

const COLORS: Record<State, string> = { free: "#4cc38a", touches: "#ff9e4a", unreached: "#f0616d" };
const NAMES: Record<State, string> = { free: "free", touches: "touches", unreached: "out of reach" };
const PICKED = "#38bdf8";
const WORST: readonly State[] = ["unreached", "touches", "free"];
const OWNER = "process";

/** Whether clicks in the view pick edges: one alone, or one more. */
const picking = signal<"" | "alone" | "more">("");

const aim = featureAim(placeAt, (found) => {
  const how = picking.peek();
  leave(aim);
  if (found && how) void pick(found.node, found.feature.point.toArray(), how === "more");
}, () => (picking.value = ""));

function togglePicking(how: "alone" | "more"): void {
  if (picking.peek() === how) return leave(aim);
  takeClicks(aim);
  picking.value = how;
}

/** Returns the lines of ways: each piece as the worse of its ends is. */
function drawn(): Span[] {
  const at = ([x, y, z]: readonly number[]) => ({ x, y, z });
  const pieces = (points: readonly (readonly number[])[], color: (place: number) => string) =>
    points.slice(1).map((point, place): Span => ({ from: at(points[place]), to: at(point), color: color(place) }));
  if (picked.value) return pieces(picked.value.points, () => PICKED);
  return looks.value.flatMap(({ points, states }) =>
    pieces(points, (place) => COLORS[WORST.find((state) => states[place] === state || states[place + 1] === state)!]));
}

export function Process() {
  useEffect(() => {
    void listNames();
    const off = effect(() => showSpans(OWNER, drawn()));
    return () => {
      off();
      leave(aim);
      showSpans(OWNER, []);
    };
  }, []);
  return (
    <>
      {text.value ? (
        <div class="modeller process">
          <textarea class="mono" aria-label="Text of the process" aria-invalid={fault.value !== ""} spellcheck={false} value={text.value} onInput={(event) => write(event.currentTarget.value)} />
          <Beside />
        </div>
      ) : (
        <p class="hint grow">Choose a process to begin with its example for the robot that is chosen, or open its file. Then pick an edge of a part in the view, look along it, plan and run.</p>
      )}
      <Bar />
    </>
  );
}

/** What is said and found beside the text. */
function Beside() {
  const told = said.value;
  return (
    <div class="beside">
      {told && (
        <div class="fields" role="group" aria-label="Tolerance and speed">
          <Degrees field="rotation" name="turn" most={180} value={told.rotation} />
          <Degrees field="work" name="work" most={45} value={told.work} />
          <Degrees field="travel" name="travel" most={45} value={told.travel} />
          <NumberField label="Speed along the way" name="speed" value={1000 * (told.speed ?? 0)} unit="mm/s" decimals={1} write={(value) => void change("speed", value / 1000)} />
        </div>
      )}
      <div class="list" role="list" aria-label="What the process comes to">
        {picked.value && <p class="entry" role="listitem">{picked.value.told}</p>}
        {looks.value.length > 0 && <Legend />}
        {looks.value.flatMap(({ lines }) => lines.map(([state, line]) => (
          <p key={line} class="entry words" role="listitem"><i class="dot" style={{ background: COLORS[state] }} />{line}</p>
        )))}
        {plan.value?.measures.map((line) => <p key={line} class="entry words" role="listitem">{line}</p>)}
      </div>
    </div>
  );
}

/** A tolerance in degrees, by a slider or as a number. */
function Degrees({ field, name, most, value }: { field: Field; name: string; most: number; value: number | "free" | null }) {
  const number = value === "free" ? most : Number(value ?? 0);
  const label = { rotation: "Turn about the tool", work: "Work angle", travel: "Travel angle", speed: "" }[field];
  const set = (degrees: number) => void change(field, field === "rotation" && degrees >= most ? "free" : degrees);
  return (
    <span class="row">
      <NumberField label={`${label}, tolerance`} name={name} value={number} unit={value === "free" ? "° free" : "°"} decimals={0} write={set} />
      <input class="slider" type="range" min="0" max={most} step="1" value={number} aria-label={`${label}, tolerance by slider, °`} onChange={(event) => set(Number(event.currentTarget.value))} />
    </span>
  );
}

function Legend() {
  return (
    <p class="entry muted" aria-label="Colours">
      {WORST.toReversed().map((state) => <span key={state}><i class="dot" style={{ background: COLORS[state] }} />{NAMES[state]}</span>)}
    </p>
  );
}

function Bar() {
  const field = useRef<HTMLInputElement>(null);
  const process = said.value?.process ?? "";
  const idle = text.value !== "" && !busy.value;
  return (
    <div class="under">
      <select class="select" aria-label="Process" value={process} onChange={(event) => event.currentTarget.value && void begin(event.currentTarget.value)}>
        {!names.value.includes(process) && <option value={process}>{process || "a process …"}</option>}
        {names.value.map((name) => <option key={name} value={name}>{name}</option>)}
      </select>
      <input ref={field} type="file" hidden multiple id="open-process" aria-label="Process to open, with the files that it names" onChange={(event) => {
        const given = [...(event.currentTarget.files ?? [])];
        event.currentTarget.value = "";
        void open(given);
      }} />
      <button type="button" class="tool small" title="Open a process: YAML, together with the files that it names" onClick={() => field.current?.click()}><Icon name="folder-open" size={14} /></button>
      <button type="button" class="button small" disabled={!text.value} aria-pressed={picking.value === "alone"} title="Then click near an edge of a part in the view: the process goes along it" onClick={() => togglePicking("alone")}>
        <Icon name="crosshair" size={13} />{picking.value === "alone" ? "Click near an edge …" : "Pick an edge"}
      </button>
      <button type="button" class="tool small" disabled={!text.value} aria-pressed={picking.value === "more"} title="One more edge" onClick={() => togglePicking("more")}><Icon name="plus" size={14} /></button>
      <button type="button" class="button small" disabled={!idle} title="Where the tool gets to, and where something would touch" onClick={() => void look()}><Icon name="eye" size={13} />Look</button>
      <button type="button" class="button small" disabled={!idle} title="Plan it; its program is then under Program, too" onClick={() => void planIt()}><Icon name="route" size={13} />Plan</button>
      <button type="button" class="button small" disabled={!canRun.value} title="Run what was planned" onClick={() => void run()}><Icon name="play" size={13} />Run</button>
      <Verdict />
    </div>
  );
}

function Verdict() {
  const wrong = fault.value || plan.value?.fault;
  if (wrong) return <span class="grow verdict bad cut" role="alert" title={wrong}>{wrong}</span>;
  const words = busy.value === "look" ? "is looked along …" : busy.value === "plan" ? "is planned …" : running.value ? "runs"
    : plan.value ? `keeps all limits and touches nothing: ${plan.value.seconds.toFixed(1)} s` : "";
  return <span class="grow verdict muted cut" role="status">{words && `${said.value?.process ?? "it"} ${words}`}</span>;
}
