// The line at the bottom: connection, counts, the last message.
import { messages } from "../kernel/messages";
import { connection, info, items, motions, touching, trouble } from "../kernel/world";
import { drawCalls, framesPerSecond } from "../view/viewport";

export function Status() {
  const role = info.value?.role ?? 0;
  const last = messages.value.at(-1);
  const connected = connection.value === "connected";
  return (
    <footer class="status" aria-label="Status">
      <span class="row" id="connection" title={trouble.value || `${framesPerSecond.value} pictures a second, ${drawCalls.value} draw calls each`}>
        <span class={`dot ${connected ? "" : "bad"}`} />
        {connected ? "connected" : connection.value === "connecting" ? "connecting" : "disconnected"}
      </span>
      {info.value && <span>kernel {info.value.version}{ROLES[role] && `, ${ROLES[role]}`}</span>}
      <span>{count(items.value.size, "node")}</span>
      <span>{count(motions.value.length, "motion")}</span>
      <span class={touching.value.length > 0 ? "bad" : ""}>{count(touching.value.length, "collision")}</span>
      <span class={`grow last ${last?.level ?? ""}`} id="last" role="log">{last?.text}</span>
    </footer>
  );
}

const ROLES = ["", "observer", "operator", "engineer", "admin"];

function count(number: number, noun: string): string {
  return `${number} ${noun}${number === 1 ? "" : "s"}`;
}
