// Where a model of the library shall stand: by a click in the view, or by Enter at the world's origin.
import { effect, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { AxesHelper, Group, Mesh, MeshBasicMaterial, RingGeometry, type Vector3 } from "three";
import { addModel, placing, placingName } from "../kernel/loader";
import { Icon } from "../parts/icons";
import { fixed } from "../parts/numbers";
import { surfaceAt } from "../view/pointing";
import { viewport } from "./view";

const CLICK_PIXELS = 4;
const RING_METERS = 0.16;

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
  let down: PointerEvent | undefined;
  const show = (point: Vector3 | undefined) => {
    at.value = point;
    mark.visible = point !== undefined;
    if (point) mark.position.copy(point);
    view.invalidate();
  };
  const move = (event: PointerEvent) => placing.peek() && show(surfaceAt(view, event)?.point);
  const press = (event: PointerEvent) => (down = event);
  const click = (event: MouseEvent) => {
    const model = placing.peek();
    const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PIXELS;
    const point = model && still ? surfaceAt(view, event)?.point : undefined;
    if (model && point) void addModel(model, point);
  };
  view.canvas.addEventListener("pointermove", move);
  view.canvas.addEventListener("pointerdown", press);
  view.canvas.addEventListener("click", click);
  const off = effect(() => {
    if (!placing.value) show(undefined);
  });
  return () => {
    off();
    view.overlay.remove(mark);
    view.canvas.removeEventListener("pointermove", move);
    view.canvas.removeEventListener("pointerdown", press);
    view.canvas.removeEventListener("click", click);
  };
}
