// Beside the editor: what the program asks, its call stack, its data, and what it has written.
import { useEffect, useRef, useState } from "preact/hooks";
import { Icon } from "../parts/icons";
import * as program from "./program";

/** A question of the program's pendant, with its answers as buttons; without any a text is written. */
export function Asked() {
  const question = program.question.value;
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), [question]);
  if (!question) return null;
  return (
    <form class="asked" aria-label="The program asks" onSubmit={(event) => (event.preventDefault(), void program.answer(field.current!.value))}>
      <p class="words">{question.text}</p>
      <div class="answers">
        {question.choices.map((one) => <button key={one} type="button" class="button small primary" onClick={() => void program.answer(one)}>{one}</button>)}
        {question.choices.length === 0 && <input ref={field} class="field grow" aria-label="Answer" />}
        {question.choices.length === 0 && <button type="submit" class="button small primary">Answer</button>}
      </div>
    </form>
  );
}

/** The condition of a breakpoint, which somebody has asked for at its line. */
export function Condition() {
  const line = program.conditioned.value;
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), [line]);
  if (line === undefined) return null;
  const leave = () => (program.conditioned.value = undefined);
  return (
    <form class="asked" aria-label="Condition" onSubmit={(event) => (event.preventDefault(), program.setBreakpoint(line, field.current!.value.trim()), leave())}
      onKeyDown={(event) => event.key === "Escape" && leave()}>
      <p class="words">{`Line ${line}: stop if`}</p>
      <div class="answers">
        <input ref={field} class="field grow mono" aria-label={`Condition of line ${line}`} defaultValue={program.breakpoints.peek().get(line) ?? ""} />
        <button type="submit" class="button small primary">Set</button>
      </div>
    </form>
  );
}

export function Stack({ go }: { go: (line: number) => void }) {
  const frames = program.frames.value;
  if (frames.length === 0) return null;
  return (
    <section aria-label="Call stack">
      <h4>Call stack</h4>
      {frames.map(({ id, name, line, isMotion }) => (
        <button key={id} type="button" class={`entry frame ${isMotion ? "muted" : ""}`} aria-pressed={id === program.chosenFrame.value}
          onClick={() => (go(line), isMotion || void program.look(id))}>
          <Icon name={isMotion ? "route" : "chevron-right"} size={12} color={isMotion ? "var(--good)" : "var(--warning)"} />
          <span class="grow cut">{name}</span><span class="mono muted">{line}</span>
        </button>
      ))}
    </section>
  );
}

export function Data() {
  return (
    <>
      {program.scopes.value.map(({ name, reference }) => (
        <section key={reference} aria-label={name}>
          <h4><Folding holder={reference} name={name} /></h4>
          <Variables holder={reference} depth={0} />
        </section>
      ))}
    </>
  );
}

function Folding({ holder, name }: { holder: number; name: string }) {
  const isOpen = program.variables.value.has(holder);
  return (
    <button type="button" class="link folding" aria-expanded={isOpen} onClick={() => (isOpen ? program.fold(holder) : void program.unfold(holder))}>
      <Icon name={isOpen ? "chevron-down" : "chevron-right"} size={12} />{name}
    </button>
  );
}

function Variables({ holder, depth }: { holder: number; depth: number }) {
  const shown = program.variables.value.get(holder);
  if (!shown) return null;
  if (shown.length === 0) return <p class="muted nothing">none</p>;
  return (
    <>
      {shown.map((one) => (
        <div key={one.name}>
          <div class="entry variable" style={{ paddingLeft: `${8 + 12 * depth}px` }} title={one.type}>
            {one.reference ? <Folding holder={one.reference} name={one.name} /> : <span class="cut">{one.name}</span>}
            <Value of={one} />
          </div>
          {one.reference !== 0 && <Variables holder={one.reference} depth={depth + 1} />}
        </div>
      ))}
    </>
  );
}

/** A value, which an expression of the language takes the place of. */
function Value({ of }: { of: program.Variable }) {
  const [words, setWords] = useState(of.value);
  useEffect(() => setWords(of.value), [of]);
  const put = () => words !== of.value && void program.setVariable(of, words);
  return (
    <input class="mono value grow" aria-label={`Value of ${of.name}`} value={words} onInput={(event) => setWords(event.currentTarget.value)} onBlur={() => setWords(of.value)}
      onKeyDown={(event) => {
        if (event.key === "Enter") put();
        if (event.key === "Escape") setWords(of.value);
      }} />
  );
}

export function Output() {
  const end = useRef<HTMLDivElement>(null);
  const said = program.said.value;
  useEffect(() => end.current?.scrollIntoView({ block: "nearest" }), [said]);
  return (
    <section aria-label="Output" class="mono">
      {said.map(({ number, text, isFault }) => <div key={number} class={isFault ? "said bad words" : "said words"}>{text}</div>)}
      <div ref={end} />
    </section>
  );
}
