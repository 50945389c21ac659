// A trajectory of a file: drawn over its time, gone through by a slider with the robot's ghost, played, and compared with
// what was measured.
import { effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import UPlot from "uplot";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { bring } from "../kernel/loader";
import { close, halt, measured, moment, play, playing, rowAt, seek, trajectory, type Curve, type Measured, type Trajectory } from "../kernel/trajectory";
import { chosen, robots } from "../kernel/world";
import { chart, LINE_COLORS, type Line } from "../parts/chart";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { fixed, unitOf } from "../parts/numbers";
import { theme } from "../parts/theme";
import { evenly, swept } from "../view/postures";
import { showSpans } from "../view/spans";

type Quantity = "positions" | "velocities" | "efforts" | "errors";

const WAY_COLOR = "#38bdf8";
const SLIDER_STEPS = 500;

const quantity = signal<Quantity>("positions");
const unseen = signal<ReadonlySet<string>>(new Set());

// The way of the tool through all of it.
effect(() => {
  const points = trajectory.value?.curve.points ?? [];
  const at = ([x, y, z]: number[]) => ({ x, y, z });
  showSpans("trajectory", points.slice(1).map((point, place) => ({ from: at(points[place]), to: at(point), color: WAY_COLOR })));
});

/** Whether ghosts show all of it together. */
const showsWhole = signal(false);

effect(() => {
  const one = trajectory.value;
  const postures = one && showsWhole.value ? one.curve.positions.map((row) => ({
    robot: one.robot, jointPositions: Object.fromEntries(one.curve.joints.map((name, place) => [name, row[place]])),
  })) : [];
  swept.value = evenly(postures);
});

export function TrajectoryControl() {
  const one = trajectory.value;
  return (
    <>
      {one ? <Drawn one={one} /> : (
        <p class="hint grow">
          A table (CSV) with a column <code>time</code> in seconds and one for each joint in radians or meters, or JSON with <code>joint_names</code>, <code>times</code> and <code>positions</code>:
          open it here or drop it on the page. {chosen.value ? `${chosen.value} will follow it.` : "It needs a robot, which the library has."}
        </p>
      )}
      <Bar one={one} />
    </>
  );
}

function Drawn({ one }: { one: Trajectory }) {
  const host = useRef<HTMLDivElement>(null);
  const { curve } = one;
  const now = rowsOf(curve, measured.value);
  const units = unitsOf(one);
  const names = (robots.value.get(one.robot)?.joints ?? []).flatMap(({ coordinateNames }) => coordinateNames);
  const key = [one.file, curve, measured.value, theme.value, quantity.value, unseen.value];
  useEffect(() => draw(host.current!, curve, measured.value, units), key);
  const row = now && now.rows.length > 0 ? rowAt(now.times, now.rows, moment.value) : undefined;
  return (
    <>
      <div class="plot" role="group" aria-label={`${quantity.value} of ${one.file}`}>
        <div class="grow" ref={host} />
        <div class="legend">
          {curve.joints.map((name, place) => (
            <button key={name} type="button" class="series" aria-pressed={!unseen.value.has(name)} title={name} onClick={() => toggle(name)}>
              <u style={{ background: LINE_COLORS[place % LINE_COLORS.length] }} />
              <span class="grow">J{names.indexOf(name) + 1}</span>
              <span class="mono muted">{row ? fixed(row[place] * units[place].factor, quantity.value === "errors" ? 3 : 1) : "–"} {units[place].unit}</span>
            </button>
          ))}
        </div>
      </div>
      <div class="under moment">
        <button type="button" class="button primary small" id="play-trajectory" disabled={playing.value !== undefined || !!one.fault || !one.checked} title={`${one.robot} goes to its start, then through it`} onClick={() => void play()}>
          <Icon name="play" size={13} />Play
        </button>
        <button type="button" class="tool small" disabled={!playing.value} title="End the trajectory" onClick={() => void halt()}><Icon name="square" size={13} /></button>
        <input class="slider grow" type="range" min="0" max={curve.times.at(-1)} step={curve.times.at(-1)! / SLIDER_STEPS} value={moment.value} disabled={playing.value !== undefined}
          aria-label="Time of the trajectory, s" title="The ghost shows the robot at this time" onInput={(event) => seek(Number(event.currentTarget.value))} />
        <button type="button" class="chip" aria-pressed={showsWhole.value} title="Ghosts of the robot all along it" onClick={() => (showsWhole.value = !showsWhole.value)}>Whole motion</button>
        <span class="mono" id="moment">{moment.value.toFixed(3)} / {curve.times.at(-1)!.toFixed(3)} s</span>
      </div>
    </>
  );
}

function Bar({ one }: { one?: Trajectory }) {
  const field = useRef<HTMLInputElement>(null);
  const options: (readonly [Quantity, string, string])[] = [["positions", "positions", "Positions of the joints, ° or mm"]];
  if (one?.curve.velocities) options.push(["velocities", "speeds", "Speeds of the joints, °/s or mm/s"]);
  if (one?.curve.efforts) options.push(["efforts", "torques", "Torques and forces of the joints, N m or N"]);
  if (measured.value) options.push(["errors", "error", "How far what was measured is from the plan, ° or mm"]);
  const chosenQuantity = options.some(([name]) => name === quantity.value) ? quantity.value : "positions";
  if (chosenQuantity !== quantity.value) quantity.value = chosenQuantity;
  return (
    <div class="under">
      <input ref={field} type="file" hidden id="open-trajectory" aria-label="Trajectory to open" accept=".csv,.json"
        onChange={(event) => {
          const [file] = event.currentTarget.files ?? [];
          event.currentTarget.value = "";
          if (file) void bring(new Map([[file.name, file]]));
        }} />
      <button type="button" class="tool small" title="Open a trajectory: CSV or JSON" disabled={playing.value !== undefined} onClick={() => field.current?.click()}><Icon name="folder-open" size={14} /></button>
      {one && <Verdict one={one} />}
      {one && <Choice label="Quantity" options={options} chosen={quantity.value} choose={(name) => (quantity.value = name)} />}
      {one && <button type="button" class="tool small" title={`Close ${one.file}`} disabled={playing.value !== undefined} onClick={close}><Icon name="x" size={14} /></button>}
    </div>
  );
}

/** Tells what the kernel has found. */
function Verdict({ one: { file, robot, checked, fault } }: { one: Trajectory }) {
  if (fault) {
    const { words, time } = fault;
    return (
      <span class="grow verdict bad cut" role="alert" title={words}>
        {time !== undefined && time >= 0 ? <button type="button" class="link" title={`${words}. Show it`} onClick={() => seek(time)}>{words}</button> : words}
      </span>
    );
  }
  if (playing.value !== undefined) return <span class="grow verdict good cut" role="status">{robot} follows {file}</span>;
  const found = !checked ? "is checked …" : measured.value && !measured.value.real && quantity.value === "errors"
    ? "isn't measured: it is where it was commanded" : "keeps all limits and touches nothing";
  return <span class="grow verdict muted cut" role="status" title={`${file}: ${robot} ${found}`}>{file}: {robot} {found}</span>;
}

function toggle(name: string): void {
  const next = new Set(unseen.value);
  if (!next.delete(name)) next.add(name);
  unseen.value = next;
}

/** Returns what is drawn as solid lines. */
function rowsOf(curve: Curve, taken?: Measured): { times: readonly number[]; rows: readonly number[][] } | undefined {
  if (quantity.value === "errors") return taken && { times: taken.times, rows: taken.errors };
  const rows = curve[quantity.value];
  return rows && { times: curve.times, rows };
}

/** Returns factor and unit of each column. */
function unitsOf({ robot, curve }: Trajectory): { factor: number; unit: string }[] {
  const types = new Map((robots.value.get(robot)?.joints ?? []).flatMap(({ coordinateNames, type }) => coordinateNames.map((name) => [name, type] as const)));
  return curve.joints.map((name) => {
    const type = types.get(name) ?? JointType.REVOLUTE;
    if (quantity.value === "efforts") return { factor: 1, unit: type === JointType.PRISMATIC ? "N" : "N m" };
    const { factor, unit } = unitOf(type);
    return { factor, unit: quantity.value === "velocities" ? `${unit}/s` : unit };
  });
}

/** Draws into `host` until the returned function is called: what is planned, and dashed what was measured. */
function draw(host: HTMLElement, curve: Curve, taken: Measured | undefined, units: readonly { factor: number; unit: string }[]): () => void {
  const solid = rowsOf(curve, taken);
  if (!solid) return () => {};
  const columns = (rows: readonly (readonly number[])[]) => units.map(({ factor }, place) => rows.map((row) => row[place] * factor));
  const beside = taken && (quantity.peek() === "positions" || quantity.peek() === "velocities") ? taken[quantity.peek() as "positions" | "velocities"] : undefined;
  const line = (dashed: boolean) => curve.joints.map((name, place): Line => ({ color: LINE_COLORS[place % LINE_COLORS.length], show: !unseen.peek().has(name), dashed }));
  const mark = (plot: UPlot) => {
    const { ctx, bbox } = plot, x = Math.round(plot.valToPos(moment.peek(), "x", true)) + 0.5;
    ctx.save();
    ctx.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--text");
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  };
  const { plot, close: end } = chart(host, units[0]?.unit ?? "", [...line(false), ...(beside ? line(true) : [])], {
    hooks: { draw: [mark] },
    scales: { x: { time: false, range: [0, curve.times.at(-1)!] } },
  });
  const tables = [[[...solid.times], ...columns(solid.rows)], ...(beside ? [[[...taken!.times], ...columns(beside)]] : [])] as UPlot.AlignedData[];
  plot.setData(tables.length > 1 ? UPlot.join(tables) : tables[0]);
  plot.over.addEventListener("click", ({ offsetX }) => seek(plot.posToVal(offsetX, "x")));
  const off = effect(() => {
    void moment.value;
    plot.redraw(false);
  });
  return () => {
    off();
    end();
  };
}
