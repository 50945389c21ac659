// The signals of a cell beside the jogs: those of the chosen robot and its tools first, of all others as many as there is room for.
import { computed, signal } from "@preact/signals";
import { below, cellSignals, chosen } from "../kernel/world";
import { Icon } from "../parts/icons";
import { Value } from "./signals";

const FEW = 6;

const showsAll = signal(false);

const sorted = computed(() => {
  const own = new Set(below(chosen.value));
  const all = [...cellSignals.value.values()];
  return [...all.filter(({ owner }) => own.has(owner)), ...all.filter(({ owner }) => !own.has(owner))];
});

export function PendantSignals() {
  if (sorted.value.length === 0) return null;
  const more = sorted.value.length - FEW;
  return (
    <section aria-label="Signals of the cell">
      <h4>
        Signals
        {more > 0 && (
          <button type="button" class="chip" aria-pressed={showsAll.value} title="Those of other robots, too" onClick={() => (showsAll.value = !showsAll.value)}>
            {showsAll.value ? "Fewer" : `${more} more`}
          </button>
        )}
      </h4>
      {sorted.value.slice(0, showsAll.value ? undefined : FEW).map((one) => (
        <div key={one.name} class="entry" role="group" aria-label={`I/O ${one.name}`} title={one.description}>
          <Value signal={one} />
          <span class="mono grow cut">{one.name}</span>
          {one.owner && <span class="muted cut" title={`It belongs to ${one.owner}`}><Icon name="plug" size={12} /> {one.owner}</span>}
        </div>
      ))}
    </section>
  );
}
