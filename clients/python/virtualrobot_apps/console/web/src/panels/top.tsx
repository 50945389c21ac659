// The bar on top: undo, time, speed of all robots, who is here, and STOP.
import { useEffect, useRef } from "preact/hooks";
import { ClockMode } from "../generated/virtualrobot/v1/kernel_pb";
import { attempt } from "../kernel/messages";
import { redo, setSpeedFactor, undo } from "../kernel/orders";
import * as service from "../kernel/services";
import { opened, toggle } from "../kernel/shown";
import { stop, stopping } from "../kernel/stop";
import { holdTime } from "../kernel/watches";
import { clock, leases, simulationTime, speedFactor } from "../kernel/world";
import { Icon } from "../parts/icons";
import { switchTheme, theme } from "../parts/theme";
import { WhileConnected } from "../parts/while_connected";
import { FileButtons } from "./files";
import { HelpButton } from "./help";

const STEP_TICKS = 10;
const PALETTE = ["#7c5cff", "#0ea5a4", "#d9670b", "#1769c9", "#b83280"];
const WORDS = { ready: "STOP", asked: "STOP", braking: "BRAKING", stopped: "STOPPED" };

export function Top() {
  const dark = theme.value === "dark";
  const bar = useRef<HTMLElement>(null);
  useEffect(() => {
    // What stays in sight below it has to know how high it is.
    const observer = new ResizeObserver(() => document.documentElement.style.setProperty("--top-height", `${bar.current!.offsetHeight}px`));
    observer.observe(bar.current!);
    return () => observer.disconnect();
  }, []);
  return (
    <header class="top" ref={bar}>
      <div class="logo"><Icon name="robot" size={22} width={1.8} />VirtualRobot</div>
      <div class="line" />
      <WhileConnected>
        <FileButtons />
        <button type="button" class="tool" title="Undo (Ctrl-Z)" onClick={() => void undo()}><Icon name="undo-2" /></button>
        <button type="button" class="tool" title="Redo (Ctrl-Shift-Z)" onClick={() => void redo()}><Icon name="redo-2" /></button>
        <div class="grow" />
        <Time />
        <Speed />
      </WhileConnected>
      <People />
      <HelpButton />
      <button type="button" class="tool" title={dark ? "Light theme" : "Dark theme"} onClick={switchTheme}>
        <Icon name={dark ? "sun" : "moon"} />
      </button>
      <button type="button" class={`stop ${stopping.value}`} id="stop" title="Stops all robots on their paths, until somebody releases them (Space)" onClick={() => void stop()}>
        <Icon name="stop" size={18} width={2.4} />
        <span role="status">{WORDS[stopping.value]}</span>
      </button>
    </header>
  );
}

function Time() {
  const stepped = clock.value?.mode === ClockMode.STEPPED;
  const factor = clock.value?.realTimeFactor ?? 0;
  return (
    <div class="pill" role="group" aria-label="Time">
      <button type="button" class="tool small" title={stepped ? "Let time go on" : "Let time stand still"} onClick={() => void holdTime()}>
        <Icon name={stepped ? "play" : "pause"} size={15} />
      </button>
      <button type="button" class="tool small" disabled={!stepped} title={`Go on by ${STEP_TICKS} ticks`}
        onClick={() => void attempt(service.kernel.stepClock({ ticks: STEP_TICKS }))}>
        <Icon name="step-forward" size={15} />
      </button>
      <span class="mono time" id="time" title="Simulation time, s">{simulationTime.value.toFixed(2)} s</span>
      <span class="mono muted" id="rate" title="Simulated seconds for each second">
        {stepped ? "held" : `×${factor.toFixed(2)}`}
      </span>
    </div>
  );
}

function Speed() {
  const percent = Math.round(100 * speedFactor.value);
  return (
    <div class="pill" title="Speed of all robots; running motions slow down and stay on their paths">
      <button type="button" class="tool small" aria-pressed={opened.value === "speeds"} title="Speed of each robot, and of time" onClick={() => toggle("speeds")}><Icon name="gauge" size={15} /></button>
      <input class="slider" type="range" min="5" max="100" step="5" value={percent} aria-label="Speed of all robots, %"
        onChange={(event) => void setSpeedFactor(Number(event.currentTarget.value) / 100)} />
      <span class="mono percent">{percent} %</span>
    </div>
  );
}

/** Who has leased robots, so that others can't move them. */
function People() {
  return (
    <div class="people">
      {leases.value.map(({ id, owner, robots }, place) => (
        <span key={id} class="person" style={{ background: PALETTE[place % PALETTE.length] }} title={`${owner} has leased ${robots.join(", ")}`}>
          {initials(owner)}
        </span>
      ))}
    </div>
  );
}

function initials(owner: string): string {
  const words = owner.split(/[^\p{L}\p{N}]+/u).filter(Boolean);
  return words.slice(0, 2).map((word) => word[0].toUpperCase()).join("");
}
