// The catalogue of models, by kind, and files of this machine: each is added by a click, or dragged to where it shall be.
import { computed, effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { KnownModel } from "../generated/virtualrobot/v1/scene_pb";
import { addModel, bring, listModels, models, placing, placingName } from "../kernel/loader";
import { forgetMissing, pass, pictures, want } from "../kernel/model_pictures";
import { chosen, connection, info } from "../kernel/world";
import { Icon } from "../parts/icons";
import { fixed } from "../parts/numbers";
import { MODEL_TYPE } from "./loading";

const filter = signal("");
const kind = signal("");

const ICONS: Record<string, string> = {
  arm: "robot", scara: "robot", palletizer: "robot", gripper: "tool", mobile: "truck", mobile_manipulator: "truck", legged: "footprints", axis: "move-horizontal",
};

const kinds = computed(() => [...new Set(models.value.map((one) => one.kind))].filter(Boolean).sort());

const found = computed(() => {
  const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
  return models.value.filter((one) => {
    const text = `${one.name} ${one.description} ${one.maker} ${one.kind}`.toLowerCase();
    return (!kind.value || one.kind === kind.value) && words.every((word) => text.includes(word));
  });
});

// Another kernel may know others.
effect(() => {
  if (connection.value !== "connected" || !info.value) return;
  forgetMissing();
  void listModels();
});

export function Library() {
  return (
    <>
      <label class="search">
        <Icon name="search" size={14} />
        <input placeholder="Filter models" aria-label="Filter models" value={filter.value} onInput={(event) => (filter.value = event.currentTarget.value)} />
      </label>
      <div class="chips kinds" role="group" aria-label="Kinds">
        {["", ...kinds.value].map((one) => (
          <button key={one} type="button" class="chip" aria-pressed={kind.value === one} onClick={() => (kind.value = one)}>
            {one.replaceAll("_", " ") || "all"}
          </button>
        ))}
      </div>
      <div class="models" role="list" aria-label="Models">
        {found.value.map((model) => <Model key={model.name} model={model} />)}
        {found.value.length === 0 && models.value.length > 0 && <p class="hint">No model is called so.</p>}
      </div>
      <Chooser />
    </>
  );
}

function Model({ model }: { model: KnownModel }) {
  const { name, description, installed, license } = model;
  const isPlaced = placing.value?.name === name;
  const missing = !installed && model.package ? `needs the package ${model.package} where the kernel runs` : "";
  const toggle = () => {
    placingName.value = "";
    placing.value = isPlaced ? undefined : model;
  };
  return (
    <div class={`model ${missing ? "off" : ""}`} role="listitem" data-model={name} draggable={!missing} title={missing || `${description}\n${license}`}
      onDragStart={(event) => event.dataTransfer?.setData(MODEL_TYPE, name)}>
      <button type="button" class="pick" aria-pressed={isPlaced} aria-label={`Place ${name}`} disabled={!!missing} onClick={toggle}>
        <Tile model={model} />
        <span class="grow">
          <span class="cut">{name}</span>
          <span class="muted cut">{description}</span>
          <span class="mono muted">{missing ? "not installed" : numbers(model)}</span>
        </span>
      </button>
      {model.kind === "gripper" && chosen.value && !missing && (
        <button type="button" class="button small" title={`Mount it on the flange of ${chosen.value}`} onClick={() => void addModel(model, undefined, chosen.value)}>Mount</button>
      )}
    </div>
  );
}

/** The picture of a model, once it has been seen; till then, and where there is none, the icon of its kind. */
function Tile({ model: { name, kind, installed } }: { model: KnownModel }) {
  const tile = useRef<HTMLSpanElement>(null);
  const address = pictures.value.get(name);
  useEffect(() => {
    if (!installed || address !== undefined) return;
    const observer = new IntersectionObserver(([{ isIntersecting }]) => (isIntersecting ? want(name) : pass(name)));
    observer.observe(tile.current!);
    return () => (observer.disconnect(), pass(name));
  }, [name, installed, address]);
  return (
    <span ref={tile} class="tile">
      {address ? <img src={address} alt="" draggable={false} /> : <Icon name={ICONS[kind] ?? "box"} size={20} color={kind === "gripper" ? "var(--tool)" : "var(--robot)"} />}
    </span>
  );
}

function numbers({ axes, reachMeters, payloadKilograms }: KnownModel): string {
  return [
    axes > 0 && `${axes} axes`,
    reachMeters > 0 && `${fixed(1000 * reachMeters, 0)} mm`,
    payloadKilograms > 0 && `${Number(payloadKilograms.toFixed(2))} kg`,
  ].filter(Boolean).join(" · ");
}

/** Takes files of this machine, which are dragged to the page as well. */
function Chooser() {
  const field = useRef<HTMLInputElement>(null);
  return (
    <div class="footer">
      <input ref={field} type="file" multiple hidden id="files" aria-label="Files to load"
        onChange={(event) => {
          const files = new Map([...(event.currentTarget.files ?? [])].map((file) => [file.name, file] as const));
          event.currentTarget.value = "";
          void bring(files);
        }} />
      <button type="button" class="button grow" title={`A model with its meshes, a scene or a zip archive: ${info.value?.modelFormats.join(" ") ?? ""}`} onClick={() => field.current?.click()}>
        <Icon name="file-up" size={14} />Load files …
      </button>
    </div>
  );
}
