// Signals of the cell: what they are, and set by hand.
import type { Signal } from "../generated/virtualrobot/v1/signal_pb";
import { setSignal } from "../kernel/orders";
import { cellSignals } from "../kernel/world";
import { NumberField } from "../parts/number_field";

export function Signals() {
  return (
    <div class="list signals">
      {cellSignals.value.size === 0 && <p class="hint">This cell has no signals.</p>}
      {[...cellSignals.value.values()].map((one) => (
        <div key={one.name} class="entry" title={one.description}>
          <Value signal={one} />
          <span class="mono">{one.name}</span>
          <span class="muted grow cut">{one.description}</span>
        </div>
      ))}
    </div>
  );
}

function Value({ signal: { name, value, unit } }: { signal: Signal }) {
  const kind = value?.kind;
  switch (kind?.case) {
    case "boolean":
      return (
        <button type="button" role="switch" class="switch" aria-label={name} aria-checked={kind.value}
          onClick={() => void setSignal(name, { case: "boolean", value: !kind.value })} />
      );
    case "integer":
      return <NumberField label={name} value={Number(kind.value)} unit={unit} decimals={0} write={(to) => void setSignal(name, { case: "integer", value: BigInt(Math.round(to)) })} />;
    case "number":
      return <NumberField label={name} value={kind.value} unit={unit} decimals={3} write={(to) => void setSignal(name, { case: "number", value: to })} />;
    case "text":
      return <span class="mono">{kind.value || "–"}</span>;
    case "group":
      return <span class="mono">{kind.value.values.map((on) => (on ? "1" : "0")).join("")}</span>;
    default:
      return null;
  }
}
