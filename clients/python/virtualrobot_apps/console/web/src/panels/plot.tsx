// Joints of the chosen robot over time.
import { computed, effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { chosen, clock, hearers, robots, simulationTime, states } from "../kernel/world";
import { chart, LINE_COLORS } from "../parts/chart";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { fixed, unitOf } from "../parts/numbers";
import { theme } from "../parts/theme";

type Quantity = "positions" | "velocities";

const MOST = 900;
const LEGEND_ROWS = 12;
/** Length (s) of the axis where there is one moment alone. */
const HELD_SECONDS = 1;
/** Longest axis (s): of a robot that has stood for an hour a jog would be a spike. */
const SHOWN_SECONDS = 60;

const quantity = signal<Quantity>("positions");
const paused = signal(false);
const unseen = signal<ReadonlySet<string>>(new Set());
const samples: { times: number[]; positions: number[][]; velocities: number[][] } = { times: [], positions: [], velocities: [] };

const isTimed = computed(() => clock.value !== undefined);

effect(() => {
  void chosen.value;
  forget();
  if (isTimed.value) take(simulationTime.peek());
});

hearers.states.add(take);

function take(time: number): void {
  const state = states.peek().get(chosen.peek());
  if (!state || paused.peek()) return;
  const last = samples.times.at(-1);
  if (last !== undefined && time < last) forget();
  if (time === last) return;
  if (samples.times.length === MOST) for (const list of [samples.times, samples.positions, samples.velocities]) list.shift();
  samples.times.push(time);
  samples.positions.push(state.positions);
  samples.velocities.push(state.velocities);
}

/** Returns what is drawn: nothing is told while nothing moves, so values are held until the next ones, and until now. */
function held(): { times: number[]; rows: number[][] } {
  const { times } = samples, rows = samples[quantity.peek()];
  const first = times[0], last = times[times.length - 1], now = Math.max(last, simulationTime.peek()), begin = now - SHOWN_SECONDS;
  const old = times.findLastIndex((time) => time <= begin), shown = old + 1;
  const before = old >= 0 ? [begin] : now === first ? [first - HELD_SECONDS] : [], after = now > last ? [now] : [];
  return {
    times: [...before, ...times.slice(shown), ...after],
    rows: [...before.map(() => rows[Math.max(old, 0)]), ...rows.slice(shown), ...after.map(() => rows[rows.length - 1])],
  };
}

function forget(): void {
  samples.times = [];
  samples.positions = [];
  samples.velocities = [];
}

interface Column {
  name: string;
  place: number;
  factor: number;
  unit: string;
}

/** Returns the joints of one coordinate, in the order of values. */
function columns(): Column[] {
  let place = 0;
  return (robots.value.get(chosen.value)?.joints ?? []).flatMap(({ name, type, coordinateCount, velocityCount }) => {
    const at = place;
    place += quantity.value === "positions" ? coordinateCount : velocityCount;
    return coordinateCount === 1 && type !== JointType.FLOATING ? [{ name, place: at, ...unitOf(type) }] : [];
  });
}

export function Plot() {
  const host = useRef<HTMLDivElement>(null);
  const shown = columns();
  const state = states.value.get(chosen.value);
  const key = JSON.stringify([shown, theme.value, quantity.value, [...unseen.value]]);
  useEffect(() => draw(host.current!, shown), [key]);
  return (
    <>
      <div class="plot">
        <div class="grow" ref={host} />
        <div class="legend">
          {shown.slice(0, LEGEND_ROWS).map(({ name, place, factor, unit }, number) => (
            <button key={name} type="button" class="series" aria-pressed={!unseen.value.has(name)} title={name} onClick={() => toggle(name)}>
              <u style={{ background: LINE_COLORS[number % LINE_COLORS.length] }} />
              <span class="grow">J{number + 1}</span>
              <span class="mono muted">{fixed((state?.[quantity.value][place] ?? 0) * factor, 1)} {unit}</span>
            </button>
          ))}
        </div>
      </div>
      <div class="under">
        <button type="button" class="tool small" title={paused.value ? "Go on" : "Hold the plot"} onClick={() => (paused.value = !paused.value)}>
          <Icon name={paused.value ? "play" : "pause"} size={14} />
        </button>
        <span class="muted grow cut">{chosen.value || "no robot"}</span>
        <Choice label="Quantity" options={[["positions", "positions", "Positions of the joints, ° or mm"], ["velocities", "velocities", "Velocities of the joints, °/s or mm/s"]]} chosen={quantity.value} choose={(one) => (quantity.value = one)} />
      </div>
    </>
  );
}

function toggle(name: string): void {
  const next = new Set(unseen.value);
  if (!next.delete(name)) next.add(name);
  unseen.value = next;
}

/** Draws into `host` until the returned function is called. */
function draw(host: HTMLElement, shown: readonly Column[]): () => void {
  const lines = shown.map(({ name }, number) => ({ color: LINE_COLORS[number % LINE_COLORS.length], show: !unseen.peek().has(name) }));
  const { plot, close } = chart(host, shown[0]?.unit ?? "", lines);
  const update = () => {
    if (paused.peek() || samples.times.length === 0) return;
    const { times, rows } = held();
    host.dataset.from = times[0].toFixed(1);
    plot.setData([times, ...shown.map(({ place, factor }) => rows.map((row) => row[place] * factor))]);
  };
  update();
  const timer = setInterval(update, 100);
  return () => {
    clearInterval(timer);
    close();
  };
}
