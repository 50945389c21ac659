// A plot of anything over time: which curves, and how they have been.
import { signal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import type UPlot from "uplot";
import { add, drawn, drop, fault, followed, held, listStreams, MOST, streams, unitOf, wanted } from "../kernel/curves";
import { chart, LINE_COLORS } from "../parts/chart";
import { Icon } from "../parts/icons";
import { theme } from "../parts/theme";

const MOST_OFFERED = 400;

const text = signal("");

const colorOf = (place: number) => LINE_COLORS[place % LINE_COLORS.length];

export function CurvesPanel() {
  const host = useRef<HTMLDivElement>(null), plot = useRef<UPlot | undefined>(undefined);
  const { times, curves } = drawn.value;
  const names = curves.map(({ name }) => name);
  const units = new Set(wanted.value.map(unitOf));
  const unit = units.size === 1 ? [...units][0] : "";
  useEffect(() => (void listStreams(), followed()), []);
  useEffect(() => {
    const lines = names.map((_, place) => ({ color: colorOf(place), show: true }));
    const made = chart(host.current!, unit && ` ${unit}`, lines);
    plot.current = made.plot;
    return () => (made.close(), (plot.current = undefined));
  }, [JSON.stringify(names), unit, theme.value]);
  useEffect(() => {
    if (times.length > 0) plot.current?.setData([times, ...curves.map(({ values }) => values)]);
  }, [drawn.value, theme.value, unit]);
  return (
    <>
      <div class="plot" role="group" aria-label="Curves over time">
        <div class="grow" ref={host} />
        <div class="legend">
          {wanted.value.length === 0 && <p class="hint">Any number of any stream: poses, speeds, forces, signals. <code>A - B</code> is a difference.</p>}
          {curves.map(({ name, values }, place) => (
            <span key={name} class="series" title={name}>
              <u style={{ background: colorOf(place) }} />
              <span class="grow cut">{name.replaceAll(/(^| - )\/\w+\//g, "$1")}</span>
              <span class="mono muted">{written(values.at(-1))}</span>
            </span>
          ))}
        </div>
      </div>
      <div class="under">
        <button type="button" class="tool small" title={held.value ? "Go on" : "Hold the plot"} onClick={() => (held.value = !held.value)}>
          <Icon name={held.value ? "play" : "pause"} size={14} />
        </button>
        <Adder />
        <div class="chips grow" role="list" aria-label="Curves">
          {wanted.value.map((one) => (
            <span key={one} role="listitem" class="chip" title={one}>
              <span class="cut">{one}</span>
              <button type="button" title={`Draw ${one} no more`} onClick={() => drop(one)}><Icon name="x" size={11} /></button>
            </span>
          ))}
        </div>
        {fault.value && <span class="bad cut" role="alert" title={fault.value}>{fault.value}</span>}
      </div>
    </>
  );
}

/** Takes a curve: a stream, a number of one, or a difference. */
function Adder() {
  const list = useId();
  const offered = [...new Set([...streams.value.map(({ name }) => name), ...drawn.value.known])].slice(0, MOST_OFFERED);
  return (
    <form class="row" onSubmit={(event) => (event.preventDefault(), add(text.value.trim()), (text.value = ""))}>
      <label class="field node-field">
        <input aria-label="Curve: a stream, or STREAM:NUMBER" placeholder="/robots/arm/tcp:speed" list={list} value={text.value} onInput={(event) => (text.value = event.currentTarget.value)} />
        <datalist id={list}>{offered.map((one) => <option key={one} value={one} />)}</datalist>
      </label>
      <button type="submit" class="button small" disabled={!text.value.trim() || wanted.value.length >= MOST}><Icon name="plus" size={13} />Draw</button>
    </form>
  );
}

function written(value: number | null | undefined): string {
  return value === null || value === undefined ? "–" : String(Number(value.toPrecision(5)));
}
