// The panel of a program as a text: editor, what is wrong in it, where it stands, its data, what it asks and writes.
import { useEffect, useRef } from "preact/hooks";
import { download } from "../kernel/loader";
import { attempt, say } from "../kernel/messages";
import { wordsOf } from "../kernel/words";
import { chosen, robots } from "../kernel/world";
import { Icon } from "../parts/icons";
import { Asked, Condition, Data, Output, Stack } from "./aside";
import { CodeEditor } from "./editor";
import { faults, lacks, layOut, show } from "./language";
import * as program from "./program";

const ENDINGS = ".mod,.modx,.sys,.sysx,.prg,.script,.urscript";
const AXES = 6;

let editor: CodeEditor | undefined;

export function CodePanel() {
  return (
    <>
      <div class="code">
        <Text />
        <div class="aside list">
          <Asked />
          <Condition />
          <Stack go={(line) => editor?.go(line)} />
          <Data />
          <Output />
        </div>
      </div>
      <Wrong />
      <Bar />
    </>
  );
}

function Text() {
  const host = useRef<HTMLDivElement>(null);
  const isScript = program.isScript.value, name = program.name.value, text = program.text.value, state = program.state.value;
  const called = program.frames.value.find(({ id }) => id === program.chosenFrame.value)?.line;
  const program_ = program.programLine.value, motion = program.motionLine.value;
  useEffect(() => {
    const made = (editor = new CodeEditor(host.current!, program.text.peek(), program.isScript.peek(), {
      changed: (to, breakpoints) => {
        program.text.value = to;
        program.breakpoints.value = breakpoints;
      },
      pressed,
    }));
    return () => (made.close(), (editor = undefined));
  }, []);
  useEffect(() => editor?.speak(isScript), [isScript]);
  useEffect(() => {
    // The newest one: what was typed since this was drawn is in it.
    editor?.write(program.text.peek());
    show(name, program.text.peek());
  }, [name, text]);
  useEffect(() => editor?.mark(program.breakpoints.value), [program.breakpoints.value, name]);
  useEffect(() => editor?.tell(faults.value), [faults.value]);
  useEffect(() => editor?.hold(state !== undefined), [state !== undefined]);
  useEffect(() => editor?.light({ program: program_, motion, called: called === program_ ? undefined : called, stands: state === "stands" }), [program_, motion, called, state]);
  // Keys that are pressed here are meant for the text.
  return <div ref={host} class="text" data-typed role="group" aria-label="Text" />;
}

function pressed(line: number, conditional: boolean): void {
  if (conditional) program.conditioned.value = line;
  else program.setBreakpoint(line, program.breakpoints.peek().has(line) ? undefined : "");
}

/** The first fault of the text, or why there is nobody to look for any. */
function Wrong() {
  const [first] = faults.value;
  if (lacks.value) return <p class="wrong bad cut" role="alert">{lacks.value}</p>;
  if (!first) return null;
  const line = first.range.start.line + 1, more = faults.value.length - 1;
  return (
    <button type="button" class="wrong link bad" id="first-fault" title="Go there" onClick={() => editor?.go(line)}>
      {`line ${line}: ${first.message}`}{more > 0 && ` (and ${more} more)`}
    </button>
  );
}

function Bar() {
  const state = program.state.value, stands = state === "stands", empty = program.text.value.trim() === "";
  const field = useRef<HTMLInputElement>(null);
  return (
    <div class="under program-bar">
      <Robot />
      <span class="grow" />
      <input class="title" aria-label="File of the program" title="Its ending tells the language: .mod is RAPID, .script is URScript" value={program.name.value} disabled={!!state}
        onChange={(event) => (program.name.value = event.currentTarget.value.trim() || program.name.peek())} />
      <input ref={field} type="file" accept={ENDINGS} hidden id="open-code" aria-label="Text to open" onChange={(event) => {
        const [file] = event.currentTarget.files ?? [];
        event.currentTarget.value = "";
        if (file) void attempt(file.text().then((text) => program.open(file.name, text)));
      }} />
      <button type="button" class="tool small" title="Open a text" disabled={!!state} onClick={() => field.current?.click()}><Icon name="folder-open" size={14} /></button>
      <button type="button" class="tool small" id="save-code" title="Save the text" disabled={empty} onClick={() => download(new Blob([program.text.peek()], { type: "text/plain" }), program.name.peek())}><Icon name="save" size={14} /></button>
      <button type="button" class="tool small" title="Lay the text out" disabled={empty || !!state} onClick={() => void format()}><Icon name="list-ordered" size={14} /></button>
      <span class="split" />
      <button type="button" class="tool small" title="Over: to the next statement of this routine" disabled={!stands} onClick={() => void program.goOn("next")}><Icon name="redo-2" size={15} /></button>
      <button type="button" class="tool small" title="Into: to the next statement, in what it calls, too" disabled={!stands} onClick={() => void program.goOn("stepIn")}><Icon name="arrow-down" size={15} /></button>
      <button type="button" class="tool small" title="Out: to the statement after this routine" disabled={!stands} onClick={() => void program.goOn("stepOut")}><Icon name="arrow-up" size={15} /></button>
      <button type="button" class="tool small" title="End the program" disabled={!state || state === "ends"} onClick={() => void program.end()}><Icon name="square" size={14} /></button>
      {!state && <button type="button" class="button small" title="Run it, and stop before its first statement" disabled={empty} onClick={() => void program.run(true)}><Icon name="step-forward" size={13} />Step</button>}
      {stands && <button type="button" class="button small primary" onClick={() => void program.goOn("continue")}><Icon name="play" size={13} />Go on</button>}
      {state && !stands && <button type="button" class="button small primary" disabled={state !== "runs"} onClick={() => void program.pause()}><Icon name="pause" size={13} />Pause</button>}
      {!state && <button type="button" class="button small primary" id="run-code" disabled={empty} onClick={() => void program.run(false)}><Icon name="play" size={13} />Run</button>}
    </div>
  );
}

/** Which robot it moves: the chosen one, if it is an arm that the language can move. */
function Robot() {
  const arms = [...robots.value].filter(([, { joints }]) => joints.length === AXES).map(([name]) => name);
  const wanted = program.robot.value;
  useEffect(() => {
    if (program.robot.peek() === undefined) program.robot.value = arms.includes(chosen.peek()) ? chosen.peek() : (arms[0] ?? "");
  }, [arms.join()]);
  return (
    <select class="select robot" aria-label="Robot that it moves" value={wanted ?? ""} disabled={!!program.state.value} onChange={(event) => (program.robot.value = event.currentTarget.value)}>
      <option value="">{program.isScript.value ? "an arm of its own" : "moves none"}</option>
      {arms.map((name) => <option key={name} value={name}>{name}</option>)}
    </select>
  );
}

async function format(): Promise<void> {
  try {
    const laid = await layOut();
    if (laid === undefined) say("the text is laid out already", "good");
    else editor?.write(laid);
  } catch (error) {
    say(wordsOf(error), "error");
  }
}
