// Legends of the coats that are shown: which colour is how much.
import { coats, type Worn } from "../kernel/coats";
import { items, names } from "../kernel/world";

/** As many of a map's colours as a legend has. */
const STOPS = 12;

export function Legends() {
  const shown = [...coats.value.values()].filter(({ coat }) => items.value.has(names.get(coat.nodeUid) ?? ""));
  if (shown.length === 0) return null;
  // Coats of one process share a legend.
  const each = new Map(shown.map((worn) => [labelOf(worn), worn]));
  return (
    <div class="float legends" aria-label="Legends">
      {[...each].map(([label, { coat }]) => (
        <figure key={label} aria-label={label}>
          <figcaption><b class="grow cut" title={coat.title}>{coat.title}</b><span class="muted">{coat.unit}</span></figcaption>
          <div class="bar" style={{ background: `linear-gradient(to right, ${stops(coat.palette).join(", ")})` }} />
          <div class="row mono muted"><span class="grow">{short(coat.low)}</span><span>{short(0.5 * (coat.low + coat.high))}</span><span class="grow last">{short(coat.high)}</span></div>
        </figure>
      ))}
    </div>
  );
}

function labelOf({ coat }: Worn): string {
  return `${coat.title}: ${short(coat.low)} to ${short(coat.high)} ${coat.unit}, colours ${coat.colorMap}`;
}

function stops(palette: Uint8Array): string[] {
  return Array.from({ length: STOPS }, (_, place) => {
    const at = 3 * Math.round(1 + (254 * place) / (STOPS - 1));
    return `rgb(${palette.subarray(at, at + 3).join(" ")})`;
  });
}

function short(value: number): string {
  return String(Number(value.toPrecision(3)));
}
