// Colours of the words of RAPID and URScript: what is a comment, a text, a number, a reserved word.
import { HighlightStyle, StreamLanguage, syntaxHighlighting, type StringStream } from "@codemirror/language";
import { tags } from "@lezer/highlight";

interface Forms {
  comment: RegExp;
  text: RegExp;
  declaring: ReadonlySet<string>;
  flow: ReadonlySet<string>;
  values: ReadonlySet<string>;
  lower: boolean;
  sign: string;
}

const wordsOf = (text: string): ReadonlySet<string> => new Set(text.split(" "));
const NUMBER = /^(0[xX][0-9a-fA-F]+|0[bB][01]+|0[oO][0-7]+|(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)/;

const RAPID: Forms = {
  comment: /^!.*/,
  text: /^"([^"]|"")*"?/,
  declaring: wordsOf("alias const endfunc endmodule endproc endrecord endtrap func inout local module pers proc record switch task trap var"),
  flow: wordsOf("and backward case connect default div do else elseif endfor endif endtest endwhile error exit for from goto if mod not or raise retry return step test then to trynext undo while with xor"),
  values: wordsOf("true false"),
  lower: true,
  sign: "!",
};
const URSCRIPT: Forms = {
  comment: /^#.*/,
  text: /^"[^"]*"?/,
  declaring: wordsOf("def global local sec thread"),
  flow: wordsOf("and break continue elif else end enter_critical exit_critical halt if join kill not or pass return run while xor"),
  values: wordsOf("True False"),
  lower: false,
  sign: "#",
};

function languageOf({ comment, text, declaring, flow, values, lower, sign }: Forms): StreamLanguage<unknown> {
  const token = (stream: StringStream): string | null => {
    if (stream.eatSpace()) return null;
    if (stream.match(comment)) return "comment";
    if (stream.match(text)) return "string";
    if (stream.match(NUMBER)) return "number";
    const found = stream.match(/^[^\W\d]\w*/);
    if (!found) {
      stream.next();
      return null;
    }
    const word = lower ? stream.current().toLowerCase() : stream.current();
    if (declaring.has(word)) return "definitionKeyword";
    if (flow.has(word)) return "keyword";
    if (values.has(word)) return "bool";
    return stream.match(/^\s*\(/, false) ? "function" : null;
  };
  return StreamLanguage.define({
    token,
    tokenTable: { function: tags.function(tags.variableName) },
    languageData: { commentTokens: { line: sign } },
  });
}

const LANGUAGES = { rapid: languageOf(RAPID), urscript: languageOf(URSCRIPT) };

export const languageFor = (isScript: boolean): StreamLanguage<unknown> => LANGUAGES[isScript ? "urscript" : "rapid"];

export const colors = syntaxHighlighting(HighlightStyle.define([
  { tag: tags.comment, color: "var(--faint)", fontStyle: "italic" },
  { tag: tags.string, color: "var(--good)" },
  { tag: [tags.number, tags.bool], color: "var(--robot)" },
  { tag: tags.definitionKeyword, color: "var(--tool)" },
  { tag: tags.keyword, color: "var(--accent)" },
  { tag: tags.function(tags.variableName), color: "var(--part)" },
]));
