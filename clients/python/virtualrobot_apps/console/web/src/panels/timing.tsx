// Signals as a timing diagram: a line each, over the same time.
import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { changes, lanes, lastPulse, type Lane } from "../kernel/timing";
import { cellSignals, simulationTime } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { fixed } from "../parts/numbers";

const WIDTH = 1000, HEIGHT = 20, EDGE = 3;
const SPANS = [["5", "5 s"], ["20", "20 s"], ["60", "60 s"]] as const;
const TICKS = 5;

const span = signal<"5" | "20" | "60">("20");
/** The time at which the diagram is held; undefined while it goes on. */
const held = signal<number | undefined>(undefined);
/** The newest simulation time that is known, which grows between changes too. */
const newest = () => Math.max(simulationTime.value, ...[...lanes.values()].map(({ times }) => times.at(-1) ?? 0));

export function Timing({ choice }: { choice: ComponentChildren }) {
  void changes.value;
  useEffect(() => () => void (held.value = undefined), []);
  const end = held.value ?? newest(), begin = end - Number(span.value);
  return (
    <>
      <div class="list timing" role="list" aria-label="Timing diagram">
        {cellSignals.value.size === 0 && <p class="hint">This cell has no signals.</p>}
        {[...cellSignals.value.keys()].map((name) => <Row key={name} name={name} lane={lanes.get(name)} begin={begin} end={end} />)}
        {cellSignals.value.size > 0 && (
          <div class="lane axis" aria-hidden="true">
            <span /><span class="scale mono muted">{Array.from({ length: TICKS + 1 }, (_, place) => <i key={place}>{fixed(begin + ((end - begin) * place) / TICKS, 1)}</i>)}</span><span />
          </div>
        )}
      </div>
      <div class="under program-bar">
        {choice}
        <span class="grow" />
        <span class="muted">simulation time, s</span>
        <Choice label="Time that is shown" options={SPANS} chosen={span.value} choose={(one) => (span.value = one)} />
        <button type="button" class="tool small" aria-pressed={held.value !== undefined} title={held.value === undefined ? "Hold the diagram; the cell goes on" : "Go on"} onClick={() => (held.value = held.value === undefined ? newest() : undefined)}>
          <Icon name={held.value === undefined ? "pause" : "play"} size={14} />
        </button>
      </div>
    </>
  );
}

function Row({ name, lane, begin, end }: { name: string; lane?: Lane; begin: number; end: number }) {
  if (!lane) return null;
  const pulse = lastPulse(lane), now = lane.values.at(-1);
  return (
    <div class="lane" role="listitem" aria-label={`Timing of ${name}`}>
      <span class="mono cut" title={name}>{name}</span>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden="true"><path d={pathOf(lane, begin, end)} vector-effect="non-scaling-stroke" /></svg>
      <span class="mono muted cut" title={pulse === undefined ? "Now" : "How long it was on last, s"}>{pulse !== undefined ? `${fixed(pulse, 3)} s` : typeof now === "number" && !Number.isInteger(now) ? fixed(now, 3) : String(now)}</span>
    </div>
  );
}

/** Returns the steps of a signal; of words it is a mark at each change. */
function pathOf({ times, values }: Lane, begin: number, end: number): string {
  const x = (time: number) => ((Math.max(time, begin) - begin) / (end - begin)) * WIDTH;
  const levels = values.map((value, place) => (typeof value === "number" ? value : place % 2));
  const first = Math.max(0, times.findLastIndex((time) => time <= begin));
  const seen = levels.slice(first);
  const least = Math.min(0, ...seen), most = Math.max(1, ...seen);
  const y = (level: number) => HEIGHT - EDGE - ((level - least) / (most - least)) * (HEIGHT - 2 * EDGE);
  let path = "";
  for (let place = first; place < times.length && times[place] <= end; place++) {
    path += `${path ? "H" : "M"}${x(times[place]).toFixed(1)}${path ? "V" : " "}${y(levels[place]).toFixed(1)}`;
  }
  return path && `${path}H${WIDTH}`;
}
