// The text (.solid) by which the selected node's body is made: read, changed as it is written, each change a step of the world.
import { effect, signal } from "@preact/signals";
import { ConnectError } from "@connectrpc/connect";
import { create } from "@bufbuild/protobuf";
import { MeshSchema, type Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { inserted } from "./solid_text";
import { attempt } from "./messages";
import { apply } from "./orders";
import { assets, scenes } from "./services";
import { assetFiles, uploadAll } from "./uploads";
import { items, selected } from "./world";

const ENDING = ".solid";
const PAUSE_MS = 500;
const FIRST = "solid: {box: {size: [0.1, 0.1, 0.1]}}\n";

/** The node whose text this is; "" for none. */
export const modelled = signal("");
export const text = signal("");
/** Why the text makes no body; the node stays as it was. */
export const fault = signal("");
/** Whether what is written is not yet what is there. */
export const waiting = signal(false);

/** Content that the text is, as the node has it. */
let known = "";
let timer: ReturnType<typeof setTimeout> | undefined;

/** Takes what is written, and gives it to the node after a pause. */
export function write(words: string): void {
  text.value = words;
  waiting.value = true;
  clearTimeout(timer);
  timer = setTimeout(() => void give(), PAUSE_MS);
}

/** Puts a word of bodies into the text, around what is selected or else around all of it. */
export function insert(word: string, from: number, to: number): void {
  write(inserted(text.peek(), word, from, to));
}

/** Adds a node with a body, and selects it. */
export async function begin(): Promise<void> {
  let name = "body";
  for (let number = 2; items.peek().has(name); number++) name = `body ${number}`;
  const mesh = await attempt(upload(name, FIRST));
  if (!mesh) return;
  const figures = [{ geometry: { case: "mesh" as const, value: mesh } }];
  if (await apply({ case: "createNode", value: { node: { name, figures, kind: { case: "object", value: {} } } } })) selected.value = name;
}

async function give(): Promise<void> {
  const name = modelled.peek(), words = text.peek();
  if (!name) return;
  try {
    const mesh = await upload(name, words);
    if (mesh.sha256 !== known) {
      const before = known;
      known = mesh.sha256;
      try {
        const figures = (items.peek().get(name)?.node.figures ?? []).map((figure) => (isSolid(figure) ? { ...figure, geometry: { case: "mesh" as const, value: create(MeshSchema, mesh) } } : figure));
        await scenes.apply({ commands: [{ command: { case: "updateNode", value: { name, node: { figures }, updateMask: { paths: ["figures"] } } } }] });
      } catch (error) {
        known = before;
        throw error;
      }
    }
    if (text.peek() === words) fault.value = "";
  } catch (error) {
    if (text.peek() === words) fault.value = ConnectError.from(error).rawMessage;
  }
  if (text.peek() === words) waiting.value = false;
}

async function upload(name: string, words: string): Promise<{ uri: string; sha256: string }> {
  const uri = `${name.replaceAll(/[^\w-]+/g, "-")}${ENDING}`;
  const course = { signal: new AbortController().signal, tell: () => {} };
  const [file] = assetFiles(await uploadAll(new Map([[uri, new File([words], uri)]]), uri, course));
  return { uri, sha256: file.sha256 };
}

/** Returns the content by which a node's body is made; "" where it comes of something else. */
function contentOf(name: string): string {
  for (const { geometry } of items.value.get(name)?.node.figures ?? []) {
    if (geometry.case === "mesh" && isSolid({ geometry })) return geometry.value.sha256;
  }
  return "";
}

function isSolid({ geometry }: Pick<Figure, "geometry">): boolean {
  return geometry.case === "mesh" && geometry.value.uri.endsWith(ENDING);
}

async function read(name: string, content: string): Promise<void> {
  const chunks: BlobPart[] = [];
  try {
    for await (const { chunk } of assets.downloadAsset({ sha256: content })) chunks.push(chunk as Uint8Array<ArrayBuffer>);
  } catch (error) {
    if (known === content) fault.value = ConnectError.from(error).rawMessage;
    return;
  }
  const words = await new Blob(chunks).text();
  if (modelled.peek() !== name || known !== content) return;
  text.value = words;
  fault.value = "";
}

// The text is the selected node's, and follows it: undo brings back the one before.
effect(() => {
  const content = contentOf(selected.value), name = content ? selected.value : "";
  if (name === modelled.peek() && content === known) return;
  clearTimeout(timer);
  modelled.value = name;
  known = content;
  text.value = fault.value = "";
  waiting.value = false;
  if (name) void read(name, content);
});
