// Where a model of the library shall stand: by a click in the view, or by Enter at the world's origin.
import { effect, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { AxesHelper, Group, Mesh, MeshBasicMaterial, RingGeometry, type Vector3 } from "three";
import type { KnownModel } from "../generated/virtualrobot/v1/scene_pb";
import { addModel, placing, placingName } from "../kernel/loader";
import { Icon } from "../parts/icons";
import { fixed, read } from "../parts/numbers";
import { leave, take, type Aim } from "../view/aiming";
import { surfaceAt } from "../view/pointing";
import { viewport } from "./view";

const RING_METERS = 0.16;

const text = signal("");
const at = signal<Vector3 | undefined>(undefined);

export function Placing() {
  useEffect(listen, []);
  const model = placing.value;
  if (!model) return null;
  const [x, y, z] = at.value?.toArray() ?? [];
  return (
    <div class="float placing" role="status">
      <Icon name="map-pin" size={16} color="var(--accent)" />
      <span>Click where <b>{model.name}</b> shall stand</span>
      <span class="mono muted place">{at.value ? [x, y, z].map((value) => fixed(1000 * value!, 0)).join(" ") : "– – –"} mm</span>
      <label class="field"><b>Name</b>
        <input aria-label="Name of the new model" placeholder={model.name} value={placingName.value} onInput={(event) => (placingName.value = event.currentTarget.value)}
          onKeyDown={(event) => event.key === "Escape" && (placing.value = undefined)} />
      </label>
      <Written model={model} />
      <button type="button" class="button small" onClick={() => void addModel(model, { x: 0, y: 0, z: 0 })}>At the origin</button>
      <button type="button" class="tool small" title="Leave it (Esc)" onClick={() => (placing.value = undefined)}><Icon name="x" size={14} /></button>
    </div>
  );
}

function listen(): () => void {
  const view = viewport.current!;
  const mark = new Group();
  const ring = new Mesh(new RingGeometry(0.86 * RING_METERS, RING_METERS, 48), new MeshBasicMaterial({ color: 0x3b9eff, transparent: true, opacity: 0.9, depthTest: false }));
  mark.add(ring, new AxesHelper(RING_METERS));
  mark.renderOrder = 940;
  mark.visible = false;
  view.overlay.add(mark);
  const show = (point: Vector3 | undefined) => {
    at.value = point;
    mark.visible = point !== undefined;
    if (point) mark.position.copy(point);
    view.invalidate();
  };
  const aim: Aim = {
    over: (_, pointer) => show(pointer && surfaceAt(view, pointer)?.point),
    click: (_, pointer) => {
      const model = placing.peek(), point = surfaceAt(view, pointer)?.point;
      if (model && point) void addModel(model, point);
    },
    left: () => (placing.value = undefined),
  };
  const off = effect(() => {
    if (placing.value) take(aim);
    else leave(aim);
  });
  return () => {
    off();
    leave(aim);
    view.overlay.remove(mark);
  };
}

/** Takes a point that is written, x, y and z in millimeters, with commas or spaces between them. */
function Written({ model }: { model: KnownModel }) {
  const words = text.value.trim().split(/[;\s]+/).filter(Boolean), numbers = words.map(read);
  const isPoint = numbers.length === 3 && numbers.every((one) => one !== undefined);
  const place = () => {
    if (!isPoint) return;
    const [x, y, z] = numbers.map((one) => one! / 1000);
    void addModel(model, { x, y, z });
  };
  return (
    <form class="row" onSubmit={(event) => (event.preventDefault(), place())}>
      <label class="field"><b>At</b>
        <input aria-label="Where it stands: x y z, mm" placeholder="0 0 0" value={text.value} aria-invalid={words.length > 0 && !isPoint} onInput={(event) => (text.value = event.currentTarget.value)} />
      </label>
      <button type="submit" class="button small" disabled={!isPoint}>Place it there</button>
    </form>
  );
}
