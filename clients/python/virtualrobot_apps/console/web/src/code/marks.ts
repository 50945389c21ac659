// Lines that are lit in the editor, and breakpoints in its gutter.
import { RangeSet, StateEffect, StateField, type Extension, type Text } from "@codemirror/state";
import { Decoration, EditorView, GutterMarker, gutter, type DecorationSet } from "@codemirror/view";

/** Lines, from 1: what the program does, what the robot makes, and what the person looks at in the call stack. */
export interface Lit {
  program?: number;
  motion?: number;
  called?: number;
  /** Whether the program stands there. */
  stands: boolean;
}

export const light = StateEffect.define<Lit>();
export const mark = StateEffect.define<ReadonlyMap<number, string>>();

const lineOf = (name: string) => Decoration.line({ class: `cm-${name}` });
const LINES = { motion: lineOf("motion"), called: lineOf("called"), runs: lineOf("runs"), stands: lineOf("stands") };

const lit = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(shown, { effects, changes, state: { doc } }) {
    const told = effects.find((one) => one.is(light));
    return told ? decorated(doc, told.value as Lit) : shown.map(changes);
  },
  provide: (field) => EditorView.decorations.from(field),
});

function decorated(doc: Text, { program, motion, called, stands }: Lit): DecorationSet {
  const wanted = [[motion, LINES.motion], [called, LINES.called], [program, stands ? LINES.stands : LINES.runs]] as const;
  const there = wanted.filter(([line]) => line !== undefined && line <= doc.lines);
  return Decoration.set(there.map(([line, what]) => what.range(doc.line(line!).from)), true);
}

class Breakpoint extends GutterMarker {
  constructor(readonly condition: string) {
    super();
  }

  eq(other: Breakpoint): boolean {
    return other.condition === this.condition;
  }

  toDOM(): HTMLElement {
    const dot = document.createElement("div");
    dot.className = this.condition ? "cm-breakpoint conditional" : "cm-breakpoint";
    dot.title = this.condition ? `Stops here if ${this.condition}` : "Stops here";
    return dot;
  }
}

class Place extends GutterMarker {
  toDOM(): HTMLElement {
    const place = document.createElement("div");
    place.className = "cm-breakpoint none";
    return place;
  }
}

const marked = StateField.define<RangeSet<GutterMarker>>({
  create: () => RangeSet.empty,
  update(shown, { effects, changes, state: { doc } }) {
    const told = effects.find((one) => one.is(mark));
    if (!told) return shown.map(changes);
    const lines = [...(told.value as ReadonlyMap<number, string>)].filter(([line]) => line <= doc.lines).sort(([one], [other]) => one - other);
    return RangeSet.of(lines.map(([line, condition]) => new Breakpoint(condition).range(doc.line(line).from)));
  },
});

/** Returns the lines, from 1, at which breakpoints are now, with their conditions; text before them may have changed. */
export function markedLines(view: EditorView): Map<number, string> {
  const found = new Map<number, string>();
  for (const at = view.state.field(marked).iter(); at.value; at.next()) found.set(view.state.doc.lineAt(at.from).number, (at.value as Breakpoint).condition);
  return found;
}

/** Shows them; `press` is told the line at whose gutter a person has clicked, and whether with Shift, for a condition. */
export function marks(press: (line: number, conditional: boolean) => void): Extension {
  return [
    lit,
    marked,
    gutter({
      class: "cm-breakpoints",
      markers: (view) => view.state.field(marked),
      renderEmptyElements: true,
      initialSpacer: () => new Place(),
      domEventHandlers: {
        mousedown: (view, { from }, event) => {
          press(view.state.doc.lineAt(from).number, (event as MouseEvent).shiftKey);
          return true;
        },
      },
    }),
  ];
}
