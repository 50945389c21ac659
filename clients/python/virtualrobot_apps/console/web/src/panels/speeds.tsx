// Speed: of all robots, of each, of their tools; and how simulation time goes by.
import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { ClockMode } from "../generated/virtualrobot/v1/kernel_pb";
import { attempt, say } from "../kernel/messages";
import { setSpeedFactor, setTcpSpeedLimit } from "../kernel/orders";
import * as service from "../kernel/services";
import { opened } from "../kernel/shown";
import { holdTime } from "../kernel/watches";
import { clock, robotNames, speedFactor, states } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { fixed } from "../parts/numbers";

const LEAST_PERCENT = 1, MOST_PERCENT = 100;
const LEAST_RATE = 0.01, MOST_RATE = 100;
const MILLIMETERS = 1000;

const stepTicks = signal(10);

export function Speeds() {
  if (opened.value !== "speeds") return null;
  return (
    <section class="float over wide" aria-label="Speed and time" onKeyDown={(event) => event.key === "Escape" && (opened.value = "")}>
      <div class="row"><b class="grow">Speed</b><button type="button" class="tool small" title="Close" onClick={() => (opened.value = "")}><Icon name="x" size={14} /></button></div>
      <Factor name="All robots" factor={speedFactor.value} set={(factor) => void setSpeedFactor(factor)} />
      {robotNames.value.length > 0 && <p class="row muted heads"><span class="grow">Each of them, times all</span><span>tool at most, 0: no limit</span></p>}
      <div class="robots">
        {robotNames.value.map((name) => {
          const { speedFactor: own = 1, tcpSpeedLimit = 0 } = states.value.get(name) ?? {};
          return (
            <Factor key={name} name={name} factor={own} set={(factor) => void setSpeedFactor(factor, name)}>
              <NumberField label={`Greatest speed of the tool of ${name}, 0 is no limit`} value={MILLIMETERS * tcpSpeedLimit} unit="mm/s" decimals={0} write={(to) => void setTcpSpeedLimit(Math.max(0, to) / MILLIMETERS, name)} />
            </Factor>
          );
        })}
      </div>
      <Time />
    </section>
  );
}

interface FactorProps {
  name: string;
  factor: number;
  set: (factor: number) => void;
  children?: ComponentChildren;
}

function Factor({ name, factor, set, children }: FactorProps) {
  const percent = 100 * (factor || 1);
  const label = `Speed of ${name === "All robots" ? "all robots" : name}, ${LEAST_PERCENT} to ${MOST_PERCENT} %`;
  const write = (to: number) => {
    if (to >= LEAST_PERCENT && to <= MOST_PERCENT) set(to / 100);
    else say(`a speed is ${LEAST_PERCENT} to ${MOST_PERCENT} %, not ${fixed(to, 0)}`, "error");
  };
  return (
    <div class="row factor" role="group" aria-label={`Speed of ${name}`}>
      <span class="cut name" title={name}>{name}</span>
      <input class="slider grow" type="range" min={LEAST_PERCENT} max={MOST_PERCENT} value={percent} aria-label={label.replace(",", " by slider,")} title={label} onChange={(event) => set(Number(event.currentTarget.value) / 100)} />
      <NumberField label={label} value={percent} unit="%" decimals={Math.abs(percent - Math.round(percent)) < 0.05 ? 0 : 1} write={write} />
      {children}
    </div>
  );
}

function Time() {
  const now = clock.value;
  if (!now) return null;
  const stepped = now.mode === ClockMode.STEPPED;
  const milliseconds = Number(now.tickNanoseconds) / 1e6;
  const write = (to: number) => {
    if (to >= LEAST_RATE && to <= MOST_RATE) void attempt(service.kernel.setClock({ mode: ClockMode.REALTIME, speedFactor: to }));
    else say(`time goes ${LEAST_RATE} to ${MOST_RATE} times as fast as the wall clock, not ${fixed(to, 2)}`, "error");
  };
  return (
    <>
      <p class="row heads"><b class="grow">Simulation time</b><span class="mono muted" title="Length of a tick; ticks that began late since the kernel started">{fixed(milliseconds, 1)} ms a tick, {String(now.lateTicks)} late</span></p>
      <div class="row">
        <Choice label="Time" options={[["on", "goes on"], ["held", "stands still"]]} chosen={stepped ? "held" : "on"} choose={(one) => (one === "held") !== stepped && void holdTime()} />
        <span class="grow" />
        <NumberField label={`Simulated seconds for each second that are aimed at, ${LEAST_RATE} to ${MOST_RATE}`} value={now.speedFactor} unit="×" decimals={2} write={write} />
        <span class="mono muted reached" title="Simulated seconds for each second that were reached lately">{stepped ? "held" : `×${fixed(now.realTimeFactor, 2)}`}</span>
      </div>
      <div class="row">
        <NumberField label="Ticks of a step" value={stepTicks.value} unit="ticks" decimals={0} write={(to) => (stepTicks.value = Math.max(1, Math.round(to)))} />
        <span class="mono muted grow">= {fixed(stepTicks.value * milliseconds, 0)} ms</span>
        <button type="button" class="button small" disabled={!stepped} title={stepped ? "Go on by so many ticks" : "Time must stand still"} onClick={() => void attempt(service.kernel.stepClock({ ticks: stepTicks.value }))}><Icon name="step-forward" size={13} />Step</button>
      </div>
    </>
  );
}
