// How the editor looks, in the page's own colours.
import { EditorView } from "@codemirror/view";

const TOOLTIP = { background: "var(--raised)", border: "1px solid var(--line)", borderRadius: "6px", boxShadow: "var(--shadow)", color: "var(--text)", zIndex: "20" };

export const looks = EditorView.theme({
  "&": { background: "var(--panel)", color: "var(--text)", fontSize: "12px", height: "100%" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.5", overflow: "auto" },
  ".cm-content": { caretColor: "var(--text)" },
  ".cm-cursor": { borderLeftColor: "var(--text)" },
  ".cm-gutters": { background: "var(--panel)", border: "none", color: "var(--faint)" },
  ".cm-activeLine": { background: "color-mix(in srgb, var(--raised) 55%, transparent)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": { background: "var(--selected)" },
  ".cm-matchingBracket, &.cm-focused .cm-matchingBracket": { background: "var(--accent-ground)", outline: "none" },
  ".cm-runs": { background: "color-mix(in srgb, var(--accent) 22%, transparent)", boxShadow: "inset 3px 0 var(--accent)" },
  ".cm-stands": { background: "color-mix(in srgb, var(--warning) 26%, transparent)", boxShadow: "inset 3px 0 var(--warning)" },
  ".cm-motion": { background: "color-mix(in srgb, var(--good) 18%, transparent)", boxShadow: "inset 3px 0 var(--good)" },
  ".cm-called": { background: "color-mix(in srgb, var(--warning) 12%, transparent)" },
  ".cm-breakpoints": { cursor: "pointer", width: "14px" },
  ".cm-breakpoint": { background: "var(--danger)", borderRadius: "50%", height: "9px", margin: "5px 2px 0", width: "9px" },
  ".cm-breakpoint.none": { background: "none" },
  ".cm-breakpoint.conditional": { background: "var(--warning)" },
  ".cm-gutter-lint": { width: "14px" },
  ".cm-gutter-lint .cm-lint-marker": { height: "10px", width: "10px" },
  ".cm-tooltip": TOOLTIP,
  ".cm-tooltip.cm-tooltip-autocomplete > ul": { fontFamily: "var(--mono)", maxHeight: "12em" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": { background: "var(--accent-deep)", color: "#fff" },
  ".cm-completionDetail": { color: "var(--muted)", fontStyle: "normal" },
  ".cm-diagnostic": { padding: "4px 8px", whiteSpace: "pre-wrap" },
  ".cm-told": { maxHeight: "16em", maxWidth: "520px", overflow: "auto", padding: "2px 10px" },
  ".cm-told pre": { fontFamily: "var(--mono)", margin: "6px 0", whiteSpace: "pre-wrap" },
  ".cm-told p": { margin: "6px 0", whiteSpace: "pre-wrap" },
});
