// The modeller: the text by which the selected node's body is made, changed where it stands, and buttons for its words; or joints.
import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { begin, fault, insert, modelled, text, waiting, write } from "../kernel/modeller";
import { AROUND, BODIES, JOINED } from "../kernel/solid_text";
import { selected } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { Jointing } from "./jointing";

const PARTS = [["text", "Text"], ["joint", "Joint"]] as const;
const shown = signal<(typeof PARTS)[number][0]>("text");

const GROUPS = [
  { name: "Bodies", words: BODIES, title: "joined to what is there" },
  { name: "Join", words: JOINED, title: "of what is there and one more" },
  { name: "Repeat", words: AROUND, title: "around what is there" },
];
const TITLES: Record<string, string> = { extrude: "A profile drawn upwards", lathe: "A profile turned about z", difference: "Cut", row: "In a row", ring: "Around z" };

export function Modeller() {
  const choice = <Choice label="What is made" options={PARTS} chosen={shown.value} choose={(one) => (shown.value = one)} />;
  if (shown.value === "text") return <Text>{choice}</Text>;
  return (
    <>
      <Jointing />
      <div class="under">{choice}</div>
    </>
  );
}

function Text({ children }: { children: ComponentChildren }) {
  const field = useRef<HTMLTextAreaElement>(null);
  const put = (word: string) => {
    const { selectionStart = 0, selectionEnd = 0 } = field.current ?? {};
    insert(word, selectionStart, selectionEnd);
    field.current?.setSelectionRange(0, 0);
  };
  return (
    <>
      {modelled.value ? (
        <div class="modeller">
          <textarea ref={field} class="mono" aria-label={`Text of ${modelled.value}`} aria-invalid={fault.value !== ""} spellcheck={false} value={text.value} onInput={(event) => write(event.currentTarget.value)} />
          <div class="words-of-bodies">
            {GROUPS.map(({ name, words, title }) => (
              <div key={name} class="chips" role="group" aria-label={name}>
                {Object.keys(words).map((word) => (
                  <button key={word} type="button" class="chip" title={`${TITLES[word] ?? word}: ${title}, or around what is selected in the text`} onClick={() => put(word)}>{word}</button>
                ))}
              </div>
            ))}
          </div>
        </div>
      ) : (
        <p class="hint grow">
          {selected.value && selected.value !== "world" ? `${selected.value} has no text that its body is made by.` : "Nothing is selected."} Select a body of a <code>.solid</code> file, drop such a file on the page, or begin with a new one.
        </p>
      )}
      <div class="under">
        {children}
        <button type="button" class="button small" id="new-body" title="A box at the origin, to begin with" onClick={() => void begin()}><Icon name="plus" size={13} />New body</button>
        {fault.value ? <span class="grow verdict bad cut" role="alert" title={fault.value}>{fault.value}</span> : (
          <span class="grow verdict muted cut" role="status">{!modelled.value ? "" : waiting.value ? "is made …" : `${modelled.value} is what is written, in meters: 0.1 is 100 mm; undo takes each change back`}</span>
        )}
      </div>
    </>
  );
}
