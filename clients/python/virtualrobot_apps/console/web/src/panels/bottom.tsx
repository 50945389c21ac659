// What happens below the view: joints and anything else over time, the program as steps and as a text, a trajectory, a process, signals, collisions, traces, the modeller, history, messages.
import { StepKind } from "../generated/virtualrobot/v1/history_pb";
import { messages, type Level } from "../kernel/messages";
import { lines } from "../kernel/program";
import { shownBelow as shown } from "../kernel/shown";
import { traces } from "../kernel/traces";
import { personOf } from "../kernel/words";
import { cellSignals, steps, touching } from "../kernel/world";
import { Icon } from "../parts/icons";
import { Chosen, Tabs, type Tab } from "../parts/tabs";
import { WhileConnected } from "../parts/while_connected";
import { Code } from "./code";
import { Collisions } from "./collisions";
import { CurvesPanel } from "./curves";
import { Modeller } from "./modeller";
import { Plot } from "./plot";
import { Process } from "./process";
import { Program } from "./program";
import { Proposals, waiting } from "./proposals";
import { Signals } from "./signals";
import { Traces } from "./traces";
import { TrajectoryControl } from "./trajectory";

const COLORS: Record<Level, string> = { info: "var(--muted)", good: "var(--good)", warning: "var(--warning)", error: "var(--danger)" };

/** The tools below the view. */
export function toolsBelow(): Tab[] {
  const errors = messages.value.filter(({ level }) => level === "error").length;
  return [
    { id: "plot", icon: "chart-line", name: "Joints", panel: Plot },
    { id: "curves", icon: "activity", name: "Curves", panel: CurvesPanel },
    { id: "program", icon: "list-video", name: "Program", count: lines.value.length, panel: Program },
    { id: "code", icon: "code", name: "Code", panel: Code },
    { id: "trajectory", icon: "spline", name: "Trajectory", panel: TrajectoryControl },
    { id: "process", icon: "waypoints", name: "Process", panel: Process },
    { id: "proposals", icon: "hand-helping", name: "Proposals", count: waiting(), panel: Proposals },
    { id: "signals", icon: "toggle-left", name: "Signals", count: cellSignals.value.size, panel: Signals },
    { id: "collisions", icon: "zap", name: "Collisions", count: touching.value.length, alarm: true, panel: Collisions },
    { id: "traces", icon: "route", name: "Traces", count: traces.value.length, panel: Traces },
    { id: "modeller", icon: "shapes", name: "Modeller", panel: Modeller },
    { id: "history", icon: "history", name: "History", panel: History },
    { id: "messages", icon: "message-square", name: "Messages", count: errors, alarm: true, panel: Messages },
  ];
}

export function Bottom() {
  const tabs = toolsBelow();
  return (
    <section class="bottom" aria-label="What happens">
      <Tabs label="Below" chosen={shown.value} choose={(id) => (shown.value = id)} tabs={tabs} />
      <WhileConnected><Chosen tabs={tabs} chosen={shown.value} /></WhileConnected>
    </section>
  );
}

const STEP_ICONS: Partial<Record<StepKind, string>> = {
  [StepKind.EDIT]: "pencil", [StepKind.UNDO]: "undo-2", [StepKind.REDO]: "redo-2", [StepKind.MOTION]: "play", [StepKind.SIGNAL]: "toggle-left",
};

function History() {
  return (
    <div class="list" id="history">
      {steps.value.length === 0 && <p class="hint">Nothing has been changed yet.</p>}
      {steps.value.map(({ number, kind, label, author, time, undone }) => (
        <div key={number} class={`entry ${undone ? "undone" : ""}`}>
          <span class="mono muted">{time ? new Date(1000 * Number(time.seconds)).toTimeString().slice(0, 8) : ""}</span>
          <Icon name={STEP_ICONS[kind] ?? "history"} size={13} color="var(--muted)" />
          <span class="grow cut">{label}</span>
          <span class="muted cut" title={author}>{personOf(author)}</span>
        </div>
      ))}
    </div>
  );
}

function Messages() {
  return (
    <div class="list" id="messages">
      {messages.value.length === 0 && <p class="hint">Nothing to tell.</p>}
      {messages.value.toReversed().map(({ number, time, level, text }) => (
        <div key={number} class="entry">
          <span class="mono muted">{time}</span>
          <Icon name={level === "info" || level === "good" ? "message-square" : "triangle-alert"} size={13} color={COLORS[level]} />
          <span class="grow words">{text}</span>
        </div>
      ))}
    </div>
  );
}
