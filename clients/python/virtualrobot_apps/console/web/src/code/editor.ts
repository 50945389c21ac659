// The editor: CodeMirror with the language server behind it. It is within a shadow root, where it may have styles of its
// own by the page's policy.
import { autocompletion, closeBrackets, completionKeymap, type CompletionContext, type CompletionResult } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab, toggleComment } from "@codemirror/commands";
import { bracketMatching, indentUnit } from "@codemirror/language";
import { forceLinting, lintGutter, lintKeymap, setDiagnostics, type Diagnostic } from "@codemirror/lint";
import { Compartment, EditorState } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, hoverTooltip, keymap, lineNumbers, type Tooltip } from "@codemirror/view";
import { complete, definition, hover, type Fault, type Position } from "./language";
import { colors, languageFor } from "./colors";
import { light, mark, markedLines, marks, type Lit } from "./marks";
import { looks } from "./looks";

/** What a person does in it. */
export interface Heard {
  changed(text: string, breakpoints: ReadonlyMap<number, string>): void;
  pressed(line: number, conditional: boolean): void;
}

/** Kinds of the protocol's suggestions, by its numbers, as CodeMirror calls them. */
const KINDS: Record<number, string> = { 3: "function", 5: "property", 6: "variable", 10: "property", 14: "keyword", 21: "constant", 22: "class" };
const HOVER_MS = 250;

export class CodeEditor {
  readonly #view: EditorView;
  readonly #language = new Compartment();
  readonly #editable = new Compartment();

  constructor(host: HTMLElement, text: string, isScript: boolean, heard: Heard) {
    const root = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    root.replaceChildren();
    const changed = EditorView.updateListener.of((update) => {
      if (update.docChanged) heard.changed(update.state.doc.toString(), markedLines(update.view));
    });
    this.#view = new EditorView({
      root,
      parent: root,
      state: EditorState.create({
        doc: text,
        extensions: [
          marks(heard.pressed), lineNumbers(), lintGutter(), history(), drawSelection(), highlightActiveLine(), bracketMatching(), closeBrackets(),
          indentUnit.of("  "), colors, looks, changed,
          this.#language.of(languageFor(isScript)), this.#editable.of([]),
          autocompletion({ override: [suggestions] }), hoverTooltip(told, { hoverTime: HOVER_MS }),
          keymap.of([
            { key: "F12", run: (view) => (void goToDeclaration(view), true) },
            { key: "Mod-/", run: toggleComment },
            ...completionKeymap, ...lintKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab,
          ]),
          EditorView.contentAttributes.of({ "aria-label": "Program's text", spellcheck: "false" }),
        ],
      }),
    });
  }

  get text(): string {
    return this.#view.state.doc.toString();
  }

  /** Puts another text in place, of which undo knows; nothing where it is the same. */
  write(text: string): void {
    if (text !== this.text) this.#view.dispatch({ changes: { from: 0, to: this.#view.state.doc.length, insert: text } });
  }

  speak(isScript: boolean): void {
    this.#view.dispatch({ effects: this.#language.reconfigure(languageFor(isScript)) });
  }

  /** Has it be changed no more, or again. */
  hold(held: boolean): void {
    this.#view.dispatch({ effects: this.#editable.reconfigure(EditorState.readOnly.of(held)) });
  }

  tell(faults: readonly Fault[]): void {
    const doc = this.#view.state.doc;
    const found = faults.map(({ range, message }): Diagnostic => ({ from: placeOf(this.#view, range.start), to: placeOf(this.#view, range.end), severity: "error", message }));
    this.#view.dispatch(setDiagnostics(this.#view.state, found.filter(({ to }) => to <= doc.length)));
    forceLinting(this.#view);
  }

  mark(breakpoints: ReadonlyMap<number, string>): void {
    this.#view.dispatch({ effects: mark.of(breakpoints) });
  }

  /** Lights lines; the one that the program does is brought into sight. */
  light(lit: Lit): void {
    this.#view.dispatch({ effects: light.of(lit) });
    const line = lit.called ?? lit.program;
    if (line !== undefined && line <= this.#view.state.doc.lines) this.#show(this.#view.state.doc.line(line).from, "nearest");
  }

  /** Goes to a line, from 1. */
  go(line: number): void {
    const at = this.#view.state.doc.line(Math.min(line, this.#view.state.doc.lines)).from;
    this.#view.dispatch({ selection: { anchor: at } });
    this.#show(at, "center");
    this.#view.focus();
  }

  close(): void {
    this.#view.destroy();
  }

  #show(at: number, y: "nearest" | "center"): void {
    this.#view.dispatch({ effects: EditorView.scrollIntoView(at, { y, yMargin: 20 }) });
  }
}

function placeOf(view: EditorView, { line, character }: Position): number {
  const doc = view.state.doc;
  if (line >= doc.lines) return doc.length;
  const { from, to } = doc.line(line + 1);
  return Math.min(from + character, to);
}

function positionOf(view: EditorView | { state: EditorState }, at: number): Position {
  const line = view.state.doc.lineAt(at);
  return { line: line.number - 1, character: at - line.from };
}

async function goToDeclaration(view: EditorView): Promise<void> {
  const found = await definition(positionOf(view, view.state.selection.main.head)).catch(() => undefined);
  if (found) view.dispatch({ selection: { anchor: placeOf(view, found.start), head: placeOf(view, found.end) }, scrollIntoView: true });
}

async function suggestions(context: CompletionContext): Promise<CompletionResult | null> {
  const word = context.matchBefore(/\w+/), sign = context.matchBefore(/[.\\]/);
  if (!word && !sign && !context.explicit) return null;
  // The server is sent the text as it is typed: what it suggests is asked for behind that.
  const items = await complete(positionOf(context, context.pos)).catch(() => []);
  const options = items.map(({ label, kind, detail, documentation }) => ({ label, type: KINDS[kind] ?? "text", detail, info: documentation || undefined }));
  return options.length === 0 ? null : { from: word?.from ?? context.pos, options, validFor: /^\w*$/ };
}

async function told(view: EditorView, at: number): Promise<Tooltip | null> {
  const words = await hover(positionOf(view, at)).catch(() => "");
  return words ? { pos: at, above: true, create: () => ({ dom: drawn(words) }) } : null;
}

/** Returns Markdown of the kind that the server writes: pieces of a program, and words about them. */
function drawn(words: string): HTMLElement {
  const told = document.createElement("div");
  told.className = "cm-told";
  for (const [number, piece] of words.split("```").entries()) {
    if (!piece.trim()) continue;
    const element = document.createElement(number % 2 === 1 ? "pre" : "p");
    element.textContent = number % 2 === 1 ? piece.replace(/^\w*\n/, "").trimEnd() : piece.trim();
    told.append(element);
  }
  return told;
}
