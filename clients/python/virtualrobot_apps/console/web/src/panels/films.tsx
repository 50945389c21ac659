// Films: of the view as it is looked at from now, or of a camera of the scene; stopped, and saved on this machine.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { filming, films, followed, remove, start, stop, type Film, type Size } from "../kernel/films";
import { opened } from "../kernel/shown";
import { megabytes } from "../kernel/uploads";
import { items } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { viewport } from "./view";

const SIZES: Record<string, Size> = { "640": [640, 360], "1280": [1280, 720], "1920": [1920, 1080] };
const SIZE_NAMES = [["640", "640×360"], ["1280", "1280×720"], ["1920", "1920×1080"]] as const;

const KIBIBYTE = 1024;

const camera = signal("");
const size = signal<"640" | "1280" | "1920">("1280");

export function Films() {
  const isOpen = opened.value === "films", isFollowed = isOpen || filming();
  useEffect(() => (isFollowed ? followed() : undefined), [isFollowed]);
  return isOpen ? <Panel /> : null;
}

function Panel() {
  const cameras = [...items.value.values()].filter(({ kind }) => kind === "cameraSensor").map(({ name }) => name);
  const from = cameras.includes(camera.value) ? camera.value : "";
  const begin = () => {
    const observer = viewport.current?.observer;
    if (from) void start(from);
    else if (observer) void start(observer.viewpoint, SIZES[size.value]);
  };
  return (
    <section class="float over wide films" aria-label="Films" onKeyDown={(event) => event.key === "Escape" && (opened.value = "")}>
      <div class="row"><b class="grow">Films</b><button type="button" class="tool small" title="Close" onClick={() => (opened.value = "")}><Icon name="x" size={14} /></button></div>
      <div class="row">
        <select class="select grow" aria-label="What is filmed" value={from} onChange={(event) => (camera.value = event.currentTarget.value)}>
          <option value="">The view, from here</option>
          {cameras.map((name) => <option key={name} value={name}>{name}</option>)}
        </select>
        <button type="button" class="button small film" id="film" title="Begin a film: 25 pictures for each second of simulation time" onClick={begin}><i />Film</button>
      </div>
      {!from && <div class="row"><span class="muted grow">Pixels</span><Choice label="Size in pixels" options={SIZE_NAMES} chosen={size.value} choose={(one) => (size.value = one)} /></div>}
      <div role="list" aria-label="Films taken">
        {films.value.length === 0 && <p class="muted">The kernel draws them, without the handles and panels of this page. They are kept until the console ends, the last eight.</p>}
        {films.value.map((film) => <Row key={film.name} film={film} />)}
      </div>
    </section>
  );
}

function Row({ film: { name, camera: from, phase, seconds, behind, bytes, fault } }: { film: Film }) {
  const left = behind > 0 ? `, ${behind} pictures to draw` : "";
  const words = { taken: `is taken${left}`, drawn: `is drawn${left}`, whole: bytes < KIBIBYTE ** 2 ? `${Math.ceil(bytes / KIBIBYTE)} KiB` : megabytes(bytes), failed: fault }[phase];
  return (
    <div class="row film-row" role="listitem" aria-label={name}>
      <Icon name="video" size={14} color={phase === "taken" ? "var(--danger)" : "var(--muted)"} />
      <span class="mono">{seconds.toFixed(1)} s</span>
      <span class={`grow cut ${phase === "failed" ? "bad" : "muted"}`} title={fault || `${name}${from && ` of ${from}`}`}>{from || "view"} · {words}</span>
      {phase === "taken" && <button type="button" class="button small" onClick={() => void stop(name)}><Icon name="square" size={12} />Stop</button>}
      {phase === "whole" && <a class="button small" href={`/films/${name}`} download={name}><Icon name="download" size={13} />Save</a>}
      <button type="button" class="tool small" title={`Remove ${name}`} onClick={() => void remove(name)}><Icon name="trash-2" size={13} /></button>
    </div>
  );
}
