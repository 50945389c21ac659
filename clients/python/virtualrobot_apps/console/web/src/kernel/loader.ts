// What is loaded: models of the catalogue, files and scenes that a person gives; and how the cell is saved.
import { signal } from "@preact/signals";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { Code, ConnectError } from "@connectrpc/connect";
import { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import type { AssetFile } from "../generated/virtualrobot/v1/nodes_pb";
import type { CreatedNode, FileWarning, KnownModel, ModelSourceSchema } from "../generated/virtualrobot/v1/scene_pb";
import { packed, unpacked } from "./archives";
import { open as openConnections } from "./connections";
import { endingOf, lastPart, type Files } from "./file_names";
import { attempt, say } from "./messages";
import { reasonOf } from "./page_calls";
import { read } from "./program";
import { ask } from "./question";
import { assets, scenes } from "./services";
import { shownBelow } from "./shown";
import { open as openTrajectory } from "./trajectory";
import { assetFiles, checkSize, megabytes, uploadAll, type Course } from "./uploads";
import { chosen, info, items, selected } from "./world";

export type Place = { x: number; y: number; z: number };

/** What is being loaded: how far it is, or why it was refused. */
export interface Loading {
  name: string;
  words: string;
  /** Part of what goes that has gone, 0 to 1; undefined where that isn't known. */
  part?: number;
  refused: boolean;
  cancel(): void;
}

export const loads = signal<Loading | undefined>(undefined);
export const models = signal<readonly KnownModel[]>([]);

/** A model of the catalogue that a person is about to place, and the name that it shall have; "" for its own. */
export const placing = signal<KnownModel | undefined>(undefined);
export const placingName = signal("");

const SCENES = [".yaml", ".yml"];
const TRAJECTORIES = [".csv", ".json"];
const CODES = [".mod", ".modx", ".sys", ".sysx", ".prg", ".script", ".urscript"];
const MODELS = [".urdf", ".xacro", ".sdf", ".world"];
const WITHOUT_UNIT = new Set([".stl", ".obj", ".ply", ".off"]);
const MOST_CHOICES = 8;
const MILLIMETER = 0.001;

export async function listModels(): Promise<void> {
  const said = await attempt(scenes.listModels({}));
  if (said) models.value = said.models;
}

/** Adds a model of the catalogue where a person has said; a gripper goes to the chosen robot's flange with `mountOn`. */
export async function addModel(model: KnownModel, at?: Place, mountOn = ""): Promise<boolean> {
  const name = mountOn ? "" : placingName.peek().trim();
  const asked = placing.peek();
  placing.value = undefined; // who clicks meanwhile places nothing twice
  const done = await loading(model.name, (course) =>
    importModel({ uri: `model://${model.name}`, name, parentTNode: poseAt(mountOn ? undefined : at), mountOn }, course));
  if (!done) placing.value ??= asked;
  return done;
}

/** Loads what a person gives: a model with its meshes, a mesh, a scene, a program, a trajectory, or a zip archive of these. */
export async function bring(given: Files, at?: Place): Promise<void> {
  const names = [...given.keys()];
  if (names.length === 0) return;
  await loading(names.length === 1 ? lastPart(names[0]) : `${names.length} files`, async (course) => {
    for (const [path, file] of given) checkSize(path, file.size);
    if (given.size === 1 && CODES.includes(endingOf(names[0]))) return openCode(given.get(names[0])!);
    if (given.size === 1 && TRAJECTORIES.includes(endingOf(names[0]))) return openTrajectory(asText(given.get(names[0])!));
    const files = await unpacked(given);
    const main = await mainOf(files);
    if (main === undefined) return;
    if (SCENES.includes(endingOf(main))) return bringText(files, main, course);
    const sent = await upload(files, main, course);
    const scale = await scaleOf(main);
    if (scale === undefined) return;
    const srdf = [...sent.keys(), ...files.keys()].filter((path) => endingOf(path) === ".srdf");
    const more = srdf.length === 1 ? await upload(files, srdf[0], course) : new Map<string, string>();
    await importModel({
      uri: main,
      files: assetFiles(new Map([...sent, ...more])),
      parentTNode: poseAt(at),
      scale: scale === 1 ? undefined : { x: scale, y: scale, z: scale },
      srdfUri: more.size > 0 ? srdf[0] : "",
    }, course);
  });
}

/** Opens a program in a controller's language; its panel is loaded for that. */
async function openCode(file: File): Promise<void> {
  const { open } = await import("../code/program");
  open(file.name, await file.text());
  shownBelow.value = "code";
}

/** Saves the cell to this machine: a scene file, in an archive with the files that it names where it names any. */
export async function save(): Promise<void> {
  await loading("the cell", async (course) => {
    course.say("is written");
    const { text, files } = await scenes.saveScene({ bundle: true }, { signal: course.signal });
    if (files.length === 0) download(new Blob([text], { type: "application/yaml" }), "cell.yaml");
    else download(packed({ "scene.yaml": new TextEncoder().encode(text), ...(await contents(files, course)) }), "cell.zip");
    say(`saved the cell${files.length > 0 ? ` with ${files.length} files` : ""}`, "good");
  });
}

/** Saves a node and all that hangs below it to this machine as glTF, or a robot as URDF: alone, or in an archive with the files that it names. */
export async function saveNode(node: string, format: ".glb" | ".urdf"): Promise<void> {
  await loading(node, async (course) => {
    course.say("is written");
    const { files, warnings } = await scenes.exportModel({ node, format }, { signal: course.signal });
    for (const words of warnings) say(words, "warning");
    const written = await contents(files, course);
    const [main] = files;
    if (files.length === 1) download(new Blob([written[main.uri]]), lastPart(main.uri));
    else download(packed(written), `${lastPart(main.uri).replace(format, "")}.zip`);
    say(`saved ${node}`, "good");
  });
}

/** Returns what files of the kernel have in them, by their names. */
async function contents(files: readonly AssetFile[], course: Course): Promise<Record<string, Uint8Array<ArrayBuffer>>> {
  const found: Record<string, Uint8Array<ArrayBuffer>> = {};
  for (const [place, { uri, sha256 }] of files.entries()) {
    course.tell(place, files.length);
    const chunks: BlobPart[] = [];
    for await (const { chunk } of assets.downloadAsset({ sha256 }, { signal: course.signal })) chunks.push(chunk as Uint8Array<ArrayBuffer>);
    found[uri] = new Uint8Array(await new Blob(chunks).arrayBuffer());
  }
  return found;
}

export function download(data: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(data);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

interface Shown extends Course {
  say(words: string): void;
}

/** Does something that takes a while, and shows how far it is; returns whether it was done. One thing is loaded at a time. */
async function loading(name: string, work: (course: Shown) => Promise<void>): Promise<boolean> {
  if (loads.peek() && !loads.peek()!.refused) {
    say(`${loads.peek()!.name} is being loaded still; ${name} is not`, "warning");
    return false;
  }
  const stopping = new AbortController();
  const show = (words: string, part?: number) => (loads.value = { name, words, part, refused: false, cancel: () => stopping.abort(new ConnectError("cancelled; nothing has changed", Code.Canceled)) });
  const course: Shown = {
    signal: stopping.signal,
    tell: (sent, all) => show(all > 0 ? `${megabytes(sent)} of ${megabytes(all)}` : "", all > 0 ? sent / all : undefined),
    say: (words) => show(words),
  };
  show("is read");
  try {
    await work(course);
    loads.value = undefined;
    return true;
  } catch (error) {
    const { code, rawMessage } = ConnectError.from(stopping.signal.aborted ? stopping.signal.reason : error);
    const hint = reasonOf(error) === "MISSING_FILE" ? ". Give it along with the others, or their folder as a zip archive" : "";
    const { whole, rest } = named(name, rawMessage);
    say(whole + hint, code === Code.Canceled ? "warning" : "error");
    const refused = { name, words: rest + hint, refused: true, cancel: () => (loads.value = undefined) };
    loads.value = code === Code.Canceled ? undefined : refused;
    return false;
  }
}

/** Returns what was refused with the name of what it is about, and without it: what reads a file names it, and the line. */
function named(name: string, said: string): { whole: string; rest: string } {
  if (!said.startsWith(name)) return { whole: `${name}: ${said}`, rest: said };
  const [place, line] = /^:(?:(\d+):)? /.exec(said.slice(name.length)) ?? [];
  const rest = place === undefined ? said : said.slice(name.length + place.length);
  return { whole: said, rest: line === undefined ? rest : `line ${line}: ${rest}` };
}

async function upload(files: Files, main: string, course: Shown): Promise<Map<string, string>> {
  course.say("is sent");
  return uploadAll(files, main, course);
}

async function importModel(model: MessageInitShape<typeof ModelSourceSchema>, course: Shown): Promise<void> {
  course.say("is read by the kernel");
  const said = await scenes.importModel({ model }, { signal: course.signal });
  told(said.created, said.warnings);
}

function told(created: readonly CreatedNode[], warnings: readonly FileWarning[]): void {
  for (const { text } of warnings) say(text, "warning");
  const [first] = created;
  if (!first) return;
  say(`${first.name} is here${created.length > 1 ? `, with ${created.length - 1} more nodes` : ""}`, "good");
  selected.value = first.name;
  if (items.peek().get(first.name)?.kind === "robot") chosen.value = first.name;
}

/** Loads a text in the project's own formats: a scene, a program, or connections. */
async function bringText(files: Files, main: string, course: Shown): Promise<void> {
  const file = asText(files.get(main)!);
  const text = await file.text();
  if (/^(steps|moves)\s*:/m.test(text)) return read(text, main);
  if (/^(connections|belts)\s*:/m.test(text)) return openConnections(file);
  const sent = await upload(files, main, course);
  const add = [...items.peek().values()].every(({ kind }) => kind === "world") ? "replace" : await ask({
    title: `Open ${lastPart(main)}`,
    text: "A cell is here already. Undo brings it back in either case.",
    answers: [["replace", "Replace it"], ["add", "Add to it"]],
  });
  if (add === undefined) return;
  course.say("is read by the kernel");
  const said = await scenes.loadScene({ text, uri: main, files: assetFiles(sent), add: add === "add" }, { signal: course.signal });
  told(said.created, said.warnings);
}

/** Returns a file that is no larger than a text may be; throws for others. */
function asText(file: File): File {
  const most = Number(info.peek()?.maxMessageBytes ?? Infinity);
  if (file.size > most) throw new ConnectError(`${file.name} has ${megabytes(file.size)}, and a text may have ${megabytes(most)} (limit message_bytes)`, Code.ResourceExhausted);
  return file;
}

/** Returns the file that is meant: a scene before a model before a mesh; of several of a kind the person says which. */
async function mainOf(files: Files): Promise<string | undefined> {
  const known = info.peek()?.modelFormats ?? MODELS;
  const paths = [...files.keys()];
  for (const kind of [SCENES, MODELS, known]) {
    const found = paths.filter((path) => kind.includes(endingOf(path)) && known.concat(SCENES).includes(endingOf(path)));
    if (found.length === 1) return found[0];
    if (found.length > 1) {
      return ask({
        title: "Which one?",
        text: found.length > MOST_CHOICES ? `The first ${MOST_CHOICES} of ${found.length} are shown; give fewer files for another one.` : "The others go along where it names them.",
        answers: found.slice(0, MOST_CHOICES).map((path) => [path, path] as const),
      });
    }
  }
  const words = `${paths.map(lastPart).slice(0, 3).join(", ")}: no file of a known kind. Known are scenes and programs (${SCENES.join(", ")}), ${known.join(", ")} and .zip`;
  throw new ConnectError(words, Code.InvalidArgument);
}

/** Returns the factor to meters of a mesh: some formats don't say it. */
async function scaleOf(main: string): Promise<number | undefined> {
  if (!WITHOUT_UNIT.has(endingOf(main))) return 1;
  const answer = await ask({
    title: `In what unit is ${lastPart(main)}?`,
    text: `A ${endingOf(main)} file doesn't tell.`,
    answers: [["mm", "Millimeters"], ["m", "Meters"]],
  });
  return answer === undefined ? undefined : answer === "mm" ? MILLIMETER : 1;
}

function poseAt(at?: Place): MessageInitShape<typeof PoseSchema> | undefined {
  return at && create(PoseSchema, { position: at, orientation: { x: 0, y: 0, z: 0, w: 1 } });
}
