// The figures of a node: sizes of primitives and colours, changed where they stand.
import type { Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { change } from "../kernel/orders";
import type { Item } from "../kernel/world";
import { Icon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { ROUGHNESS } from "../view/figures";

const MOST_ROWS = 12;
const MILLIMETERS = 1000;

export function Figures({ item: { name, node } }: { item: Item }) {
  if (node.figures.length === 0) return null;
  const write = (place: number, edit: (figure: Figure) => void) => void change(name, "figures", ({ figures }) => figures[place] && edit(figures[place]));
  return (
    <section aria-label="Figures">
      <h4>Figures <span class="badge">{node.figures.length}</span></h4>
      {node.figures.slice(0, MOST_ROWS).map((figure, place) => <Row key={place} figure={figure} write={(edit) => write(place, edit)} />)}
    </section>
  );
}

function Row({ figure, write }: { figure: Figure; write: (edit: (figure: Figure) => void) => void }) {
  const { geometry, material, toolState } = figure;
  const color = material?.color;
  const parts = color && [color.red, color.green, color.blue].map((part) => Math.round(255 * part).toString(16).padStart(2, "0"));
  const paint = (text: string) => write(({ material }) => {
    const [red, green, blue] = [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
    if (material?.color) Object.assign(material.color, { red, green, blue });
  });
  return (
    <>
      <div class="entry">
        <Icon name="box" size={14} color="var(--muted)" />
        <span class="grow cut">{geometry.case === "mesh" ? geometry.value.uri.split("/").at(-1) : geometry.case}</span>
        {toolState && <span class="muted">{toolState}</span>}
        {parts && <input type="color" class="color" aria-label="Colour" title="Its colour" value={`#${parts.join("")}`} onChange={(event) => paint(event.currentTarget.value)} />}
      </div>
      <div class="pose">
        {sizesOf(figure).map(({ name, label, meters, set }) => (
          <NumberField key={name} label={label} name={name} unit="mm" decimals={1} value={MILLIMETERS * meters}
            write={(to) => write((copy) => set(copy, to / MILLIMETERS))} />
        ))}
        {material && (["roughness", "metalness"] as const).map((field) => (
          <NumberField key={field} label={`${field === "roughness" ? "Roughness: 0 is a mirror, 1 is matt" : "Metalness"}, %`} name={field === "roughness" ? "Rough" : "Metal"} unit="%" decimals={0}
            value={100 * (material[field] ?? (field === "roughness" ? ROUGHNESS : 0))}
            write={(to) => write((copy) => copy.material && (copy.material[field] = Math.min(1, Math.max(0, to / 100))))} />
        ))}
      </div>
    </>
  );
}

interface Size {
  name: string;
  label: string;
  meters: number;
  set: (figure: Figure, meters: number) => void;
}

/** Returns the sizes of a primitive; none of other figures. */
function sizesOf({ geometry }: Figure): Size[] {
  if (geometry.case === "box") {
    return (["x", "y", "z"] as const).map((axis) => ({
      name: axis.toUpperCase(), label: `Size along ${axis.toUpperCase()}`, meters: geometry.value.size?.[axis] ?? 0,
      set: (figure, meters) => figure.geometry.case === "box" && figure.geometry.value.size && (figure.geometry.value.size[axis] = meters),
    }));
  }
  if (geometry.case !== "sphere" && geometry.case !== "cylinder" && geometry.case !== "cone" && geometry.case !== "capsule") return [];
  const across: Size = {
    name: "Ø", label: "Diameter", meters: 2 * geometry.value.radiusMeters,
    set: ({ geometry: one }, meters) => "value" in one && one.value && "radiusMeters" in one.value && (one.value.radiusMeters = meters / 2),
  };
  if (geometry.case === "sphere") return [across];
  const long: Size = {
    name: "Z", label: "Length", meters: geometry.value.lengthMeters,
    set: ({ geometry: one }, meters) => "value" in one && one.value && "lengthMeters" in one.value && (one.value.lengthMeters = meters),
  };
  return [across, long];
}
