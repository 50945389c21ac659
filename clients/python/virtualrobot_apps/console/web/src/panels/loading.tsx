// Files that are dropped on the page, and how far what is loaded is.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Files } from "../kernel/file_names";
import { addModel, bring, loads, models, type Place } from "../kernel/loader";
import { Icon } from "../parts/icons";
import { surfaceAt } from "../view/pointing";
import { viewport } from "./view";

/** What a model of the library is called among what is dragged. */
export const MODEL_TYPE = "application/x-virtualrobot-model";

const over = signal<"" | "files" | "model">("");

export function Loading() {
  useEffect(listen, []);
  return (
    <>
      {over.value === "files" && (
        <div class="veil drop" aria-hidden="true">
          <div class="float question">
            <Icon name="file-up" size={30} color="var(--accent)" />
            <h2>Drop to load</h2>
            <p class="muted">Models with their meshes, scenes, programs, trajectories, connections, or a zip archive of them</p>
          </div>
        </div>
      )}
      <Course />
    </>
  );
}

function Course() {
  const load = loads.value;
  if (!load) return null;
  const { name, words, part, refused, cancel } = load;
  return (
    <div class={`float course ${refused ? "refused" : ""}`} role={refused ? "alert" : "status"} id="loading">
      <Icon name={refused ? "triangle-alert" : "upload"} size={16} color={refused ? "var(--danger)" : "var(--accent)"} />
      <div class="grow">
        <div class="row"><b class="cut grow">{name}</b>{!refused && <span class="mono muted">{words}</span>}</div>
        {refused ? <p class="words">{words}</p> : <div class="bar"><i class={part === undefined ? "unknown" : ""} style={part === undefined ? {} : { width: `${100 * part}%` }} /></div>}
      </div>
      <button type="button" class="tool small" title={refused ? "Close" : "Cancel: nothing changes"} onClick={cancel}><Icon name="x" size={14} /></button>
    </div>
  );
}

/** Hears what is dragged over the page; in the view it is put where it is dropped. */
function listen(): () => void {
  const kindOf = (event: DragEvent) => {
    const types = event.dataTransfer?.types ?? [];
    return types.includes("Files") ? "files" : types.includes(MODEL_TYPE) ? "model" : "";
  };
  const hover = (event: DragEvent) => {
    const kind = kindOf(event);
    if (!kind) return;
    event.preventDefault();
    over.value = kind;
  };
  const leave = (event: DragEvent) => {
    if (!event.relatedTarget) over.value = "";
  };
  const end = () => (over.value = "");
  const drop = (event: DragEvent) => {
    const kind = kindOf(event);
    over.value = "";
    if (!kind || !event.dataTransfer) return;
    event.preventDefault();
    const at = placeOf(event);
    if (kind === "files") return void filesOf(event.dataTransfer).then((files) => bring(files, at));
    const name = event.dataTransfer.getData(MODEL_TYPE);
    const model = models.peek().find((one) => one.name === name);
    if (model && at) void addModel(model, at);
  };
  const heard = { dragover: hover, dragleave: leave, dragend: end, drop } as Record<string, (event: never) => void>;
  for (const [name, hear] of Object.entries(heard)) addEventListener(name, hear as EventListener);
  return () => {
    for (const [name, hear] of Object.entries(heard)) removeEventListener(name, hear as EventListener);
  };
}

function placeOf(event: DragEvent): Place | undefined {
  const view = viewport.current;
  if (!view || !(event.target instanceof Node) || !view.canvas.closest(".view")?.contains(event.target)) return undefined;
  return surfaceAt(view, event)?.point;
}

/** Returns what is dropped, the contents of folders as well, by path. */
async function filesOf(data: DataTransfer): Promise<Files> {
  // Asked for before anything is waited for: then it is gone.
  const entries = [...data.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry !== null && entry !== undefined);
  const found = new Map<string, File>();
  if (entries.length === 0) for (const file of data.files) found.set(file.name, file);
  for (const entry of entries) await walk(entry, found);
  return found;
}

async function walk(entry: FileSystemEntry, found: Map<string, File>): Promise<void> {
  if (entry.isFile) {
    found.set(entry.fullPath.replace(/^\//, ""), await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject)));
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    // A folder is read a part at a time.
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return;
    for (const one of some) await walk(one, found);
  }
}
