// Files to the kernel, each once by its content, with all that they name. They go by requests of their own, which wait for the
// kernel where it is slower than the page, tell how much has gone, and can be ended.
import { Code, ConnectError } from "@connectrpc/connect";
import { create, toBinary } from "@bufbuild/protobuf";
import { AssetService, UploadAssetRequestSchema } from "../generated/virtualrobot/v1/asset_pb";
import { AssetFileSchema } from "../generated/virtualrobot/v1/nodes_pb";
import { endingOf, findNamed, joinNames, type Files } from "./file_names";
import { assets } from "./services";
import { info } from "./world";

/** Browsers take digests, by which the kernel knows files, nowhere else. */
const BY_HTTPS = "browsers let pages send files that come from this machine or by https. `virtualrobot console --listen 0.0.0.0 --own-certificate` has it";
const CHUNK_BYTES = 1024 * 1024;
const KIBIBYTE = 1024, MEBIBYTE = 1024 * 1024;
const HEAD_BYTES = 5;
const END = 2;
const NAME_NOTHING = new Set([".stl", ".png", ".jpg", ".jpeg", ".gif", ".bmp", ".tga", ".tif", ".tiff", ".bin", ".webp"]);
const NAME_ALL_AT_ONCE = new Set([".obj", ".mtl", ".dae", ".gltf", ".glb"]);
const SCENES = new Set([".yaml", ".yml"]);
const MODELS = new Set([".urdf", ".xacro", ".sdf", ".srdf", ".xml", ...SCENES]);

/** What is told while files go: bytes of how many, in all. */
export interface Course {
  signal: AbortSignal;
  tell(sent: number, all: number): void;
}

/** Throws, naming the limit, where a file is larger than the kernel takes; nothing of it has been read then. */
export function checkSize(name: string, bytes: number): void {
  const most = Number(info.peek()?.maxAssetBytes ?? 0);
  if (!most || bytes <= most) return;
  const words = `${name} has ${megabytes(bytes)}, and a file may have ${megabytes(most)} (limit asset_bytes)`;
  throw new ConnectError(words, Code.ResourceExhausted);
}

export function megabytes(bytes: number): string {
  if (bytes < MEBIBYTE / 10) return `${Math.ceil(bytes / KIBIBYTE)} KiB`;
  return `${(bytes / MEBIBYTE).toFixed(bytes < 10 * MEBIBYTE ? 1 : 0)} MiB`;
}

/** Gives the kernel a file of these and all that it names among them, and returns them by the names that they have in each other. */
export async function uploadAll(files: Files, main: string, course: Course): Promise<Map<string, string>> {
  const sent = new Map<string, string>(); // SHA-256 by name
  const sources = new Map([[main, main]]); // paths by name
  await sendAll(files, sources, sent, course);
  let asked = [main];
  while (asked.length > 0) {
    const named = new Map<string, string>(), again = new Set<string>();
    for (const referrer of asked) {
      const fresh = [...(await namesIn(files, sent, referrer, referrer === main))].filter(([name]) => !sent.has(name));
      for (const [name, path] of fresh) {
        named.set(name, path);
        if (mayNameOthers(main, referrer, name)) again.add(name);
      }
      // What is translated may name more when it has these.
      if (fresh.length > 0 && !NAME_ALL_AT_ONCE.has(endingOf(referrer))) again.add(referrer);
    }
    await sendAll(files, named, sent, course);
    asked = [...again];
  }
  return sent;
}

export function assetFiles(sent: ReadonlyMap<string, string>) {
  return [...sent].map(([uri, sha256]) => create(AssetFileSchema, { uri, sha256 }));
}

/** Returns which of the files one names, by their joined names. Of those that are not here the kernel tells, if it has none. */
async function namesIn(files: Files, sent: ReadonlyMap<string, string>, referrer: string, isMain: boolean) {
  const found = new Map<string, string>();
  const known = NAME_ALL_AT_ONCE.has(endingOf(referrer)) ? [] : assetFiles(sent);
  try {
    const said = await assets.listReferences({ sha256: sent.get(referrer), uri: referrer, files: known });
    for (const { uri } of said.files) {
      const name = joinNames(referrer, uri);
      const path = findNamed(files, name);
      if (path !== undefined) found.set(name, path);
    }
  } catch (error) {
    // What reads the main file says what is wrong with another one, if it reads it at all.
    if (isMain) throw error;
  }
  return found;
}

function mayNameOthers(main: string, referrer: string, name: string): boolean {
  if (MODELS.has(endingOf(name))) return referrer === main && SCENES.has(endingOf(main));
  return !NAME_NOTHING.has(endingOf(name));
}

async function sendAll(files: Files, paths: ReadonlyMap<string, string>, sent: Map<string, string>, course: Course): Promise<void> {
  const fresh = new Map<string, File>();
  for (const [name, path] of paths) {
    const file = files.get(path)!;
    checkSize(path, file.size);
    const sha256 = await hashOf(file);
    course.signal.throwIfAborted();
    sent.set(name, sha256);
    fresh.set(sha256, file);
  }
  for (const sha256 of (await assets.findAssets({ sha256s: [...fresh.keys()] })).sha256s) fresh.delete(sha256);
  const all = [...fresh.values()].reduce((bytes, { size }) => bytes + size, 0);
  let gone = 0;
  for (const [sha256, file] of fresh) {
    await send(sha256, file, course.signal, (bytes) => course.tell(gone + Math.min(bytes, file.size), all));
    gone += file.size;
  }
}

async function hashOf(file: File): Promise<string> {
  let bytes: ArrayBuffer;
  try {
    bytes = await file.arrayBuffer();
  } catch {
    throw new ConnectError(`${file.name} can't be read: it is a folder, or has changed since`, Code.NotFound);
  }
  if (!isSecureContext) throw new ConnectError(`${file.name} is not sent: ${BY_HTTPS}`, Code.FailedPrecondition);
  const digest = await crypto.subtle.digest("SHA-256", bytes);
  return [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Sends a file in Connect's envelopes, each a chunk; slices of a file are read as they go. */
function send(sha256: string, file: File, signal: AbortSignal, tell: (bytes: number) => void): Promise<void> {
  const parts: BlobPart[] = [enveloped(toBinary(UploadAssetRequestSchema, create(UploadAssetRequestSchema, { sha256 })))];
  for (let start = 0; start < file.size; start += CHUNK_BYTES) {
    const chunk = file.slice(start, start + CHUNK_BYTES);
    // Field 2, bytes: its tag, its length, and then the slice itself.
    const tag = [0x12, ...varint(chunk.size)];
    parts.push(head(tag.length + chunk.size), Uint8Array.from(tag), chunk);
  }
  const request = new XMLHttpRequest();
  request.open("POST", `/${AssetService.typeName}/UploadAsset`);
  request.setRequestHeader("content-type", "application/connect+proto");
  request.setRequestHeader("client-name", "console");
  request.responseType = "arraybuffer";
  request.upload.onprogress = ({ loaded }) => tell(loaded);
  return new Promise((resolve, reject) => {
    const abort = () => request.abort();
    request.onload = () => {
      const refused = refusalIn(request.response as ArrayBuffer, request.status);
      if (refused) reject(refused);
      else resolve();
    };
    request.onerror = () => reject(new ConnectError(`the connection was lost while ${file.name} went; nothing has changed`, Code.Unavailable));
    request.onabort = () => reject(signal.reason);
    request.onloadend = () => signal.removeEventListener("abort", abort);
    signal.addEventListener("abort", abort);
    request.send(new Blob(parts));
  });
}

/** Returns what the answer's last envelope, or an answer without any, says against the upload. */
function refusalIn(answer: ArrayBuffer, status: number): ConnectError | undefined {
  const view = new DataView(answer);
  const read = (bytes: ArrayBuffer) => JSON.parse(new TextDecoder().decode(bytes) || "{}") as { message?: string; error?: { message?: string } };
  if (status !== 200) return new ConnectError(read(answer).message ?? `HTTP ${status}`, Code.Unknown);
  for (let at = 0; at + HEAD_BYTES <= answer.byteLength; at += HEAD_BYTES + view.getUint32(at + 1)) {
    if (!(view.getUint8(at) & END)) continue;
    const { error } = read(answer.slice(at + HEAD_BYTES, at + HEAD_BYTES + view.getUint32(at + 1)));
    return error && new ConnectError(error.message ?? "the upload was refused", Code.Unknown);
  }
  return new ConnectError("the connection was lost before the upload's end; nothing has changed", Code.Unavailable);
}

function enveloped(message: Uint8Array): Uint8Array<ArrayBuffer> {
  return Uint8Array.from([...head(message.length), ...message]);
}

function head(length: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(HEAD_BYTES);
  new DataView(bytes.buffer).setUint32(1, length);
  return bytes;
}

function varint(value: number): number[] {
  const bytes: number[] = [];
  for (; value > 0x7f; value >>>= 7) bytes.push((value & 0x7f) | 0x80);
  return [...bytes, value];
}
