// Views: from where the cell is looked at, along with what, saved in it under names; and what cameras of the scene see.
import { signal } from "@preact/signals";
import { Matrix4, Vector3 } from "three";
import { watched } from "../kernel/camera_picture";
import { remove } from "../kernel/orders";
import { picture, toggle, type Aid } from "../kernel/shared_picture";
import { keep, kept, readViewpoint, share, viewpointOf } from "../kernel/viewpoints";
import { chosen, items, selected, type Item } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon, KindIcon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { DEGREES } from "../parts/numbers";
import { followed } from "../view/follower";
import { SIDES, type Side } from "../view/observer";
import { RoomSection } from "./room";
import { viewport } from "./view";

const NAMES: Record<Side, string> = { front: "Front", back: "Back", left: "Left", right: "Right", top: "Top", bottom: "Bottom", iso: "Iso" };
const AHEAD_METERS = 1;

const title = signal("");

/** Looks from a side; keys 1 to 7 do so, too. */
export function turnTo(number: number): void {
  const side = (Object.keys(SIDES) as Side[])[number - 1];
  if (side) viewport.current?.observer.turn(side);
}

export function Views() {
  return (
    <div class="body" id="views">
      <section aria-label="Sides">
        <h4>Look from</h4>
        <div class="chips">
          {(Object.keys(SIDES) as Side[]).map((side, place) => (
            <button key={side} type="button" class="chip" title={`Key ${place + 1}`} onClick={() => turnTo(place + 1)}>{NAMES[side]}</button>
          ))}
        </div>
        <div class="row">
          <button type="button" class="button grow" onClick={() => viewport.current?.frame()}><Icon name="maximize" size={14} />Fit everything</button>
          <button type="button" class="button grow" disabled={!selected.value} title={`${selected.value || "Nothing is selected"} (F)`} onClick={() => viewport.current?.frame(selected.value)}><Icon name="crosshair" size={14} />Fit selection</button>
        </div>
        <div class="property">
          <span>Field of view</span>
          <NumberField label="Vertical field of view, 5 to 120" value={viewport.current?.observer.field.value ?? 0} unit="°" decimals={1} write={(to) => viewport.current?.observer.setField(to)} />
        </div>
      </section>
      <Following />
      <Kept />
      <Cameras />
      <RoomSection />
      <section aria-label="View of all">
        <h4>Viewers, pictures and films</h4>
        <div class="row">
          <button type="button" class="button grow" title="The kernel's viewer, pictures and films look from here, for everybody" onClick={() => void shareThis()}>Set from here</button>
          <button type="button" class="button grow" title="From where the viewer, pictures and films look; everything where nobody has said that" onClick={() => void lookAsAll()}>Look as they do</button>
        </div>
        <div class="chips">
          <AidChip aid="jointAxes" name={chosen.value} words="Axes of the joints" />
          <AidChip aid="boundingBoxes" name={selected.value} words="Box around it" />
        </div>
      </section>
    </div>
  );
}

/** Shows something of a node to everybody, at the page, in the room and in the kernel's viewer. */
function AidChip({ aid, name, words }: { aid: Aid; name: string; words: string }) {
  const isShown = picture.value?.[aid].includes(name) ?? false;
  return <button type="button" class="chip" aria-pressed={isShown} disabled={!name} title={`${words}: ${name || "nothing is selected"}`} onClick={() => void toggle(aid, name)}>{words}</button>;
}

async function lookAsAll(): Promise<void> {
  const shared = await readViewpoint();
  followed.value = shared?.along;
  if (shared) viewport.current?.observer.look(shared.viewpoint);
  else viewport.current?.frame();
}

/** Has all look from here, and along with what this page follows. */
async function shareThis(): Promise<void> {
  const view = viewport.current;
  if (!view) return;
  const now = followed.peek();
  const place = now && view.solids.places.get(now.node);
  await share(view.observer.viewpoint, now && place && { ...now, place });
}

function Following() {
  const now = followed.value;
  const mode = now === undefined ? "off" : now.turns ? "turn" : "along";
  const node = now?.node ?? selected.value;
  const options = [["off", "Off"], ["along", "Go along"], ["turn", "Turn with it"]] as const;
  return (
    <section aria-label="Following">
      <h4>
        <span class="cut">Follow {now && !items.value.has(now.node) ? `${now.node}, which is gone` : node || "what is selected"}</span>
      </h4>
      <Choice label="How the view follows" options={options} chosen={mode} choose={(one) => {
        if (one === "off") followed.value = undefined;
        else if (node) followed.value = { node, turns: one === "turn" };
      }} />
      {now && now.node !== selected.value && selected.value && (
        <button type="button" class="button small" onClick={() => (followed.value = { ...now, node: selected.peek() })}>Follow {selected.value} instead</button>
      )}
    </section>
  );
}

function Kept() {
  const save = async () => {
    if (await saveAs(title.peek().trim() || freeName())) title.value = "";
  };
  return (
    <section aria-label="Saved views">
      <h4>Saved views <span class="muted">in the cell</span></h4>
      <div role="list" aria-label="Views">
        {kept.value.map((item) => (
          <div key={item.uid} class="entry view-row" role="listitem" aria-label={item.name}>
            <KindIcon kind="viewpoint" size={14} />
            <button type="button" class="link grow" title={item.parent === "world" ? "Look from there" : `Look from there, along with ${item.parent}`} onClick={() => lookFrom(item)}>{item.name}</button>
            <button type="button" class="tool small" title={`Have ${item.name} look from here`} onClick={() => void saveAs(item.name)}><Icon name="save" size={13} /></button>
            <button type="button" class="tool small" title={`Drop the view ${item.name}`} onClick={() => void remove(item.name)}><Icon name="trash-2" size={13} /></button>
          </div>
        ))}
      </div>
      <form class="row" onSubmit={(event) => (event.preventDefault(), void save())}>
        <label class="field node-field grow"><input aria-label="Name of the view" placeholder={freeName()} value={title.value} maxLength={60} onInput={(event) => (title.value = event.currentTarget.value)} /></label>
        <button type="submit" class="button small"><Icon name="plus" size={13} />Save view</button>
      </form>
    </section>
  );
}

/** Saves from where this page looks; a view that turns with a node goes along with it, whoever looks from it. */
async function saveAs(name: string): Promise<boolean> {
  const view = viewport.current;
  if (!view) return false;
  const now = followed.peek();
  const parent = now?.turns && items.peek().has(now.node) && now.node !== name ? now.node : "world";
  return keep(name, view.observer.viewpoint, parent, view.solids.places.get(parent) ?? new Matrix4());
}

export function lookFrom(item: Item): void {
  const place = viewport.current?.solids.places.get(item.name);
  const viewpoint = place && viewpointOf(item, place);
  if (!viewpoint) return;
  viewport.current?.observer.look(viewpoint);
  followed.value = item.parent === "world" ? undefined : { node: item.parent, turns: true };
}

function freeName(): string {
  let number = 1;
  while (items.value.has(`View ${number}`)) number++;
  return `View ${number}`;
}

function Cameras() {
  const cameras = [...items.value.values()].filter(({ kind }) => kind === "cameraSensor");
  return (
    <section aria-label="Cameras">
      <h4>Cameras of the scene</h4>
      {cameras.length === 0 && <p class="hint">There is none. <b>Add …</b> below the tree adds one.</p>}
      {cameras.map((item) => (
        <div key={item.uid} class="entry view-row" role="listitem" aria-label={item.name}>
          <KindIcon kind="cameraSensor" size={14} />
          <button type="button" class="link grow" onClick={() => (selected.value = item.name)}>{item.name}</button>
          <button type="button" class="chip" aria-pressed={watched.value === item.name} title="Its picture in the corner of the view, as it takes it" onClick={() => (watched.value = watched.value === item.name ? "" : item.name)}>Picture</button>
          <button type="button" class="chip" title="Look from where it is, and go along with it" onClick={() => lookThrough(item)}>Look through</button>
        </div>
      ))}
    </section>
  );
}

/** Looks from where a camera is, along its z, with its field of view where it has one of a pinhole. */
function lookThrough({ name, node }: Item): void {
  const place = viewport.current?.solids.places.get(name);
  if (!place || node.kind.case !== "cameraSensor") return;
  const { width, height, horizontalFieldRadians, intrinsics } = node.kind.value;
  const wide = width || 640, high = height || 480;
  const tangent = intrinsics ? high / 2 / intrinsics.fy : (Math.tan((horizontalFieldRadians || 1) / 2) * high) / wide;
  const position = new Vector3().setFromMatrixPosition(place);
  const ahead = new Vector3(0, 0, 1).applyMatrix4(new Matrix4().extractRotation(place));
  const target = position.clone().addScaledVector(ahead, AHEAD_METERS);
  viewport.current?.observer.look({ position: position.toArray(), target: target.toArray(), fieldDegrees: 2 * Math.atan(tangent) * DEGREES });
  followed.value = { node: name, turns: true };
}
