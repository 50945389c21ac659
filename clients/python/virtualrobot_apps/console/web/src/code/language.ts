// Client of the language server (Language Server Protocol 3.17), for the one text of the panel.
import { signal } from "@preact/signals";
import { hear, send, type Message } from "./wire";

export interface Position {
  /** From 0. */
  line: number;
  /** In units of UTF-16, from 0. */
  character: number;
}

export interface Range {
  start: Position;
  end: Position;
}

export interface Fault {
  range: Range;
  message: string;
}

export interface Item {
  label: string;
  kind: number;
  detail?: string;
  documentation?: string;
}

/** What is wrong in the text that is open, as it was last told. */
export const faults = signal<readonly Fault[]>([]);
/** Why there is no language server; "" where there is one. */
export const lacks = signal("");

const waiting = new Map<number, { resolve: (result: unknown) => void; reject: (error: Error) => void }>();
let count = 0;
let begun = false;
let uri = "";
let version = 0;

hear("lsp", {
  take({ id, method, params, result, error }: Message) {
    if (typeof id === "number") {
      const asked = waiting.get(id);
      waiting.delete(id);
      if (error) asked?.reject(new Error((error as { message: string }).message));
      else asked?.resolve(result);
    } else if (method === "textDocument/publishDiagnostics") {
      const told = params as { uri: string; version?: number; diagnostics: Fault[] };
      if (told.uri !== uri || told.version !== version) return;
      faults.value = told.diagnostics;
    }
  },
  end(why) {
    begun = false;
    lacks.value = why;
    for (const { reject } of waiting.values()) reject(new Error(why));
    waiting.clear();
  },
});

/** Has a text checked in place of the one before; its name's ending tells the language. */
export function show(name: string, text: string): void {
  begin();
  const next = `page:/${encodeURIComponent(name)}`;
  if (next !== uri) {
    if (uri) tell("textDocument/didClose", { textDocument: { uri } });
    uri = next;
    faults.value = [];
    tell("textDocument/didOpen", { textDocument: { uri, languageId: "", version: ++version, text } });
  } else {
    tell("textDocument/didChange", { textDocument: { uri, version: ++version }, contentChanges: [{ text }] });
  }
}

export async function hover(position: Position): Promise<string> {
  const found = await ask<{ contents: { value: string } } | null>("textDocument/hover", { textDocument: { uri }, position });
  return found?.contents.value ?? "";
}

export async function complete(position: Position): Promise<Item[]> {
  return (await ask<{ items: Item[] }>("textDocument/completion", { textDocument: { uri }, position })).items;
}

/** Returns where the name at a place is declared; undefined where that isn't in this text. */
export async function definition(position: Position): Promise<Range | undefined> {
  const found = await ask<{ uri: string; range: Range } | null>("textDocument/definition", { textDocument: { uri }, position });
  return found?.uri === uri ? found.range : undefined;
}

/** Returns the text as it would be laid out, undefined where it is; throws why it can't be. */
export async function layOut(): Promise<string | undefined> {
  const options = { tabSize: 2, insertSpaces: true };
  const edits = await ask<{ newText: string }[]>("textDocument/formatting", { textDocument: { uri }, options });
  return edits[0]?.newText;
}

function begin(): void {
  if (begun) return;
  begun = true;
  uri = lacks.value = "";
  void ask("initialize", { processId: null, rootUri: null, capabilities: {} }).catch(() => undefined);
  tell("initialized", {});
}

function ask<T>(method: string, params: Message): Promise<T> {
  const id = ++count;
  void send("lsp", { jsonrpc: "2.0", id, method, params });
  return new Promise((resolve, reject) => waiting.set(id, { resolve: resolve as (result: unknown) => void, reject }));
}

function tell(method: string, params: Message): void {
  void send("lsp", { jsonrpc: "2.0", method, params });
}
