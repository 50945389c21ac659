// The program: steps that are taught in order, played, gone through one by one, saved and opened.
import { useEffect, useRef } from "preact/hooks";
import { MotionPhase, type Move, type ProgramStep } from "../generated/virtualrobot/v1/motion_pb";
import type { SignalValue } from "../generated/virtualrobot/v1/signal_pb";
import { bring, download } from "../kernel/loader";
import { ground } from "../kernel/parts";
import * as program from "../kernel/program";
import { cellSignals, chosen, items, robots, selected, states } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import { NumberField } from "../parts/number_field";
import { Tasks } from "./tasks";

const DWELL_SECONDS = 1;
const TIMEOUT_SECONDS = 60;

export function Program() {
  const steps = program.lines.value;
  return (
    <>
      <Tasks />
      <div class="list program" role="list" aria-label="Steps">
        {steps.length === 0 && <p class="hint">Bring the robot somewhere and teach a step, record what it does, or drop a program file here.</p>}
        {steps.map((line, place) => <Row key={line.number} {...line} place={place} />)}
      </div>
      {program.canGoBack.value && (
        <div class="under">
          <span class="muted grow cut">Play begins with the cell as it is now.</span>
          <button type="button" class="button small" title="Robots, parts and signals are where they were before Play; Undo doesn't reach behind this" onClick={() => void program.goBack()}><Icon name="rotate-ccw" size={13} />Back to before Play</button>
        </div>
      )}
      <Bar />
    </>
  );
}

function Row({ number, step, place }: program.Line & { place: number }) {
  const isLit = program.lit.value === place;
  const isNext = !program.running.value && program.next.value === place;
  const row = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (isLit) row.current?.scrollIntoView({ block: "nearest" });
  }, [isLit]);
  return (
    <div ref={row} role="listitem" class={`entry step ${isLit ? "lit" : ""} ${isNext ? "next" : ""}`} aria-current={isLit ? "step" : undefined}>
      <button type="button" class="mono number" title="Go on from here" aria-label={`Go on from step ${place + 1}`} disabled={!!program.running.value} onClick={() => (program.next.value = place)}>
        {isLit || isNext ? <Icon name="play" size={11} /> : place + 1}
      </button>
      <Words number={number} step={step} />
      <span class="acts">
        <button type="button" class="tool small" title="Up" onClick={() => program.shift(number, -1)}><Icon name="arrow-up" size={13} /></button>
        <button type="button" class="tool small" title="Down" onClick={() => program.shift(number, 1)}><Icon name="arrow-down" size={13} /></button>
        <button type="button" class="tool small" title={`Drop step ${place + 1}`} onClick={() => program.drop(number)}><Icon name="trash-2" size={13} /></button>
      </span>
    </div>
  );
}

/** Shows a step; what this panel teaches can be changed in it, and all else is kept as it is. */
function Words({ number, step: { step } }: { number: number; step: ProgramStep }) {
  switch (step.case) {
    case "move":
      return step.value.moves.length === 1
        ? <MoveWords number={number} move={step.value.moves[0]} />
        : <Other icon="move-3d" name={`${step.value.moves.length} moves together`} text={step.value.moves.map(({ robot }) => robot).join(", ")} />;
    case "dwell":
      return (
        <>
          <Icon name="hourglass" size={14} color="var(--muted)" /><b class="what">Wait</b>
          <NumberField label="Time to wait" value={step.value.seconds} unit="s" decimals={2} write={(to) => program.change(number, ({ step }) => step.case === "dwell" && (step.value.seconds = Math.max(to, 0.001)))} />
          <span class="grow" />
        </>
      );
    case "pickAt":
    case "placeAt":
      return <HandlingWords number={number} step={step} />;
    case "setSignal":
      return <SignalWords number={number} name={step.value.signal} value={step.value.value} verb="Set" />;
    case "waitSignal":
      return <SignalWords number={number} name={step.value.condition?.signal ?? ""} value={step.value.condition?.value} verb="Wait for" />;
    case "pick":
      return <Other icon="hand-grab" name="Pick" text={`${step.value.part || "the nearest part"}, with ${step.value.robot}`} />;
    case "place":
      return <Other icon="package" name="Place" text={`${step.value.part || "what is held"} on ${step.value.parent || "world"}, with ${step.value.robot}`} />;
    default:
      return <Other icon="list-ordered" name={(step.case ?? "").replace(/[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`)} text="as in its file" />;
  }
}

function MoveWords({ number, move: { robot, speedFactor, move } }: { number: number; move: Move }) {
  const edit = (changed: (one: Move) => void) => program.change(number, ({ step }) => step.case === "move" && changed(step.value.moves[0]));
  if (move.case === "toolState") {
    const kind = items.value.get(move.value.tool)?.node.kind;
    const options = kind?.case === "tool" ? kind.value.states.map(({ name }) => [name, name] as const) : [];
    return (
      <>
        <Icon name="tool" size={14} color="var(--tool)" /><b class="what cut">{move.value.tool}</b>
        <Choice label={`State of ${move.value.tool}`} options={options} chosen={move.value.state} choose={(state) => edit((one) => one.move.case === "toolState" && (one.move.value.state = state))} />
        <span class="grow" />
      </>
    );
  }
  const goal = move.case === "linear" ? move.value.goal : move.case === "pointToPoint" && move.value.goal.case === "pose" ? move.value.goal.value : undefined;
  const posture = move.case === "pointToPoint" && move.value.goal.case === "posture" ? move.value.goal.value : "";
  const isLine = move.case === "linear";
  const turn = () => edit((one) => {
    if (!goal) return;
    one.move = isLine
      ? { case: "pointToPoint", value: { $typeName: "virtualrobot.v1.PointToPoint", goal: { case: "pose", value: goal }, maxVelocityMetersPerSecond: 0, maxAngularVelocityRadiansPerSecond: 0 } }
      : { case: "linear", value: { $typeName: "virtualrobot.v1.Linear", goal, maxVelocityMetersPerSecond: 0, maxAccelerationMetersPerSecondSquared: 0, maxAngularVelocityRadiansPerSecond: 0 } };
  });
  return (
    <>
      <Icon name="map-pin" size={14} color="var(--accent)" />
      <button type="button" class="link what" title="Select the target" onClick={() => goal?.reference && (selected.value = goal.reference)}>{goal?.reference || posture || "joints"}</button>
      <button type="button" class="chip way" disabled={!goal} title="Joints together (PTP), or the tool in a straight line (LIN)" onClick={turn}>{isLine ? "LIN" : move.case === "pointToPoint" ? "PTP" : move.case}</button>
      <span class="muted grow cut">{robot}</span>
      <NumberField label="Speed" value={100 * (speedFactor || 1)} unit="%" decimals={0} write={(to) => edit((one) => (one.speedFactor = Math.min(1, Math.max(0.01, to / 100))))} />
    </>
  );
}

type Handling = Extract<ProgramStep["step"], { case: "pickAt" | "placeAt" }>;

/** A pick or a place: where, of which part or on what, how long the lines there and away are, and how wide the tool is then, or its state. */
function HandlingWords({ number, step }: { number: number; step: Handling }) {
  const { robot, goal, approachMeters, state: toolState, widthMeters, part } = step.value;
  const isPick = step.case === "pickAt";
  const edit = (changed: (one: Handling["value"]) => void) => program.change(number, ({ step }) => (step.case === "pickAt" || step.case === "placeAt") && changed(step.value));
  const now = states.value.get(robot), tool = now?.tool ?? "";
  const options = program.toolStatesOf(tool).map((name) => [name, name] as const);
  const width = now?.toolWidths[tool];
  return (
    <>
      <Icon name={isPick ? "hand-grab" : "hand-helping"} size={14} color="var(--part)" />
      <b class="what">{isPick ? "Pick" : "Place"}</b>
      <button type="button" class="link" title="Select the target" onClick={() => goal?.reference && (selected.value = goal.reference)}>{goal?.reference}</button>
      {step.case === "placeAt"
        ? <NodeField label="What it is placed on" name="on" value={step.value.parent || "world"} choose={(name) => edit((one) => Object.assign(one, { parent: name }))} />
        : <NodeField label="Part that is picked" value={part} placeholder="the nearest part" choose={(name) => edit((one) => (one.part = name))} />}
      {widthMeters === undefined && <Choice label={`State of ${tool || "the tool"} then`} options={options} chosen={toolState} choose={(to) => edit((one) => (one.state = to))} />}
      {width !== undefined && (
        <NumberField label="Width to which the tool is opened or closed then" name="↔" value={1000 * (widthMeters ?? width)} unit="mm" decimals={1}
          write={(to) => edit((one) => Object.assign(one, { widthMeters: Math.max(0, to / 1000), state: "" }))} />
      )}
      <NumberField label="Length of the lines there and away" name="↕" value={1000 * approachMeters} unit="mm" decimals={0}
        write={(to) => edit((one) => (one.approachMeters = one.retreatMeters = Math.max(0, to / 1000)))} />
    </>
  );
}

function SignalWords({ number, name, value, verb }: { number: number; name: string; value?: SignalValue; verb: string }) {
  const kind = value?.kind;
  const write = (to: SignalValue["kind"]) => program.change(number, ({ step }) => {
    const told = step.case === "setSignal" ? step.value.value : step.case === "waitSignal" ? step.value.condition?.value : undefined;
    if (told) told.kind = to;
  });
  return (
    <>
      <Icon name={verb === "Set" ? "toggle-left" : "hourglass"} size={14} color="var(--muted)" /><b class="what">{verb}</b><span class="mono">{name}</span>
      {kind?.case === "boolean" && <Choice label={`Value of ${name}`} options={[["off", "off"], ["on", "on"]]} chosen={kind.value ? "on" : "off"} choose={(one) => write({ case: "boolean", value: one === "on" })} />}
      {kind?.case === "number" && <NumberField label={`Value of ${name}`} value={kind.value} unit="" decimals={3} write={(to) => write({ case: "number", value: to })} />}
      {kind?.case === "integer" && <NumberField label={`Value of ${name}`} value={Number(kind.value)} unit="" decimals={0} write={(to) => write({ case: "integer", value: BigInt(Math.round(to)) })} />}
      <span class="grow" />
    </>
  );
}

function Other({ icon, name, text }: { icon: string; name: string; text: string }) {
  return <><Icon name={icon} size={14} color="var(--muted)" /><b class="what">{name}</b><span class="muted grow cut">{text}</span></>;
}

function Bar() {
  const run = program.running.value, empty = program.lines.value.length === 0;
  const stands = run?.phase === MotionPhase.PAUSED;
  const robot = chosen.value;
  const field = useRef<HTMLInputElement>(null);
  return (
    <div class="under program-bar">
      <button type="button" class="button small" disabled={!robot || !!run} aria-label="Teach PTP" title="A target here, reached with all joints together" onClick={() => void program.appendMove("pointToPoint")}><Icon name="map-pin" size={13} />PTP</button>
      <button type="button" class="button small" disabled={!robot || !!run} aria-label="Teach LIN" title="A target here, reached in a straight line" onClick={() => void program.appendMove("linear")}><Icon name="map-pin" size={13} />LIN</button>
      <Add />
      <button type="button" class="button small record" aria-label="Record" aria-pressed={program.recording.value} disabled={!robot} title="Take down each place where the robot comes to rest, and what its tools do" onClick={() => (program.recording.value = !program.recording.value)}><i />Record</button>
      <span class="grow" />
      <input class="title" aria-label="Name of the program" value={program.title.value} onInput={(event) => (program.title.value = event.currentTarget.value)} />
      <input ref={field} type="file" accept=".yaml,.yml" hidden id="open-program" aria-label="Program to open" onChange={(event) => {
        const [file] = event.currentTarget.files ?? [];
        event.currentTarget.value = "";
        if (file) void bring(new Map([[file.name, file]]));
      }} />
      <button type="button" class="tool small" title="Open a program file" onClick={() => field.current?.click()}><Icon name="folder-open" size={14} /></button>
      <button type="button" class="tool small" id="save-program" disabled={empty} title="Save as a program file, for virtualrobot run" onClick={() => download(new Blob([program.text()], { type: "application/yaml" }), `${program.title.value.trim() || "program"}.yaml`)}><Icon name="save" size={14} /></button>
      <button type="button" class="tool small" disabled={empty || !!run} title="Drop all steps" onClick={program.clear}><Icon name="trash-2" size={14} /></button>
      <span class="split" />
      <button type="button" class="tool small" disabled={!!run || program.next.value === 0} title="One step back" onClick={() => void program.back()}><Icon name="step-back" size={15} /></button>
      <button type="button" class="tool small" disabled={!!run || empty} title="One step" onClick={() => void program.forward()}><Icon name="step-forward" size={15} /></button>
      <button type="button" class="tool small" disabled={!run} title="End the program" onClick={() => void program.halt()}><Icon name="square" size={14} /></button>
      {run && !stands
        ? <button type="button" class="button small primary" onClick={() => void program.pause()}><Icon name="pause" size={13} />Pause</button>
        : <button type="button" class="button small primary" id="play" disabled={empty} onClick={() => void program.play()}><Icon name="play" size={13} />Play</button>}
    </div>
  );
}

/** Adds what is more than a way to here: picks, places, postures, a wait, a tool's state, a signal. */
function Add() {
  const robot = chosen.value;
  const tools = Object.entries(states.value.get(robot)?.toolStates ?? {});
  const postures = robots.value.get(robot)?.robot?.postures ?? [];
  const add = (what: string) => {
    const [kind, name] = [what.slice(0, what.indexOf(" ")), what.slice(what.indexOf(" ") + 1)];
    const value = cellSignals.peek().get(name)?.value;
    if (kind === "pickAt" || kind === "placeAt") void program.appendHandling(kind);
    if (kind === "posture") program.appendPosture(robot, name);
    if (kind === "dwell") program.append({ case: "dwell", value: { seconds: DWELL_SECONDS } });
    if (kind === "tool") program.appendTool(robot, name, tools.find(([tool]) => tool === name)?.[1] ?? "");
    if (kind === "pick") program.append({ case: "pick", value: { robot } });
    if (kind === "place") program.append({ case: "place", value: { robot, parent: ground.peek() } });
    if (kind === "set") program.append({ case: "setSignal", value: { signal: name, value } });
    if (kind === "await") program.append({ case: "waitSignal", value: { condition: { signal: name, value }, timeoutSeconds: TIMEOUT_SECONDS } });
  };
  return (
    <select class="select add" aria-label="Add a step" value="" onChange={(event) => {
      add(event.currentTarget.value);
      event.currentTarget.value = "";
    }}>
      <option value="">Add …</option>
      {states.value.get(robot)?.tool && <option value="pickAt ">Pick here, with approach</option>}
      {states.value.get(robot)?.tool && <option value="placeAt ">{`Place here on ${ground.value}, with approach`}</option>}
      {postures.map(({ name }) => <option key={name} value={`posture ${name}`}>{`Go to ${name}`}</option>)}
      <option value="dwell ">Wait for a time</option>
      {tools.map(([tool]) => <option key={tool} value={`tool ${tool}`}>{`Tool: ${tool}`}</option>)}
      {tools.length > 0 && <option value="pick ">Pick the nearest part</option>}
      {tools.length > 0 && <option value="place ">{`Place what is held on ${ground.value}`}</option>}
      {[...cellSignals.value.keys()].map((name) => <option key={`set ${name}`} value={`set ${name}`}>{`Set ${name}`}</option>)}
      {[...cellSignals.value.keys()].map((name) => <option key={`await ${name}`} value={`await ${name}`}>{`Wait for ${name}`}</option>)}
    </select>
  );
}
