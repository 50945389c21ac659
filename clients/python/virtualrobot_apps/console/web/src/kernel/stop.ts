// STOP: for everybody, always, by two ways at once; the cell stays stopped until somebody releases it.
import { fromJson, type JsonValue } from "@bufbuild/protobuf";
import { computed, effect, signal } from "@preact/signals";
import { DriverService, StopCellResponseSchema } from "../generated/virtualrobot/v1/driver_pb";
import { letGo } from "./jog";
import { attempt, say } from "./messages";
import { drivers } from "./services";
import { personOf } from "./words";
import { cell, moving } from "./world";

export type Stopping = "ready" | "asked" | "braking" | "stopped";

const REASON = "STOP in the console";
const PATIENCE_MS = 2000;
const asked = signal(false);

/** Whether this page was the first to ask for the stop that holds. */
const mine = signal(false);

/** Who has stopped the cell, for people. */
export const stoppedBy = computed(() => (mine.value ? "you" : personOf(cell.value?.stoppedBy ?? "")));

/** Why, where it is more than that button. */
export const stopReason = computed(() => (cell.value?.reason === REASON ? "" : (cell.value?.reason ?? "")));

/** How far the stop of the cell is, whoever asked for it. */
export const stopping = computed<Stopping>(() => {
  if (cell.value?.stopped) return moving.value ? "braking" : "stopped";
  return asked.value ? "asked" : "ready";
});

/** Stops all robots on their paths, by the page's socket and by a request of its own, whichever gets through first. */
export async function stop(): Promise<void> {
  letGo();
  asked.value = true;
  if (!cell.peek()?.stopped) mine.value = true;
  // Where the network is gone nothing ends for minutes; what was asked for is tried on.
  const late = setTimeout(() => say("STOP has not been heard yet. Use the robot's own stop.", "error"), PATIENCE_MS);
  try {
    const { cell: told } = await Promise.any([drivers.stopCell({ reason: REASON }), stopByRequest()]);
    cell.value = told;
  } catch (error) {
    const [first] = (error as AggregateError).errors as Error[];
    mine.value = false;
    say(`STOP was not heard: ${first.message}. Use the robot's own stop.`, "error");
  } finally {
    clearTimeout(late);
    asked.value = false;
  }
}

async function stopByRequest() {
  const reply = await fetch(`/${DriverService.typeName}/StopCell`, {
    method: "POST",
    headers: { "content-type": "application/json", "client-name": "console" },
    body: JSON.stringify({ reason: REASON }),
    keepalive: true,
  });
  const said = (await reply.json()) as JsonValue;
  if (!reply.ok) throw new Error((said as { message: string }).message);
  return fromJson(StopCellResponseSchema, said, { ignoreUnknownFields: true });
}

/** Lets robots move again after a STOP; nothing moves by that. */
export async function release(): Promise<void> {
  const answer = await attempt(drivers.releaseCell({}));
  if (answer) cell.value = answer.cell;
}

let before = stopping.peek();

effect(() => {
  const now = stopping.value;
  if (now === "stopped" && before !== now) say(`stopped by ${stoppedBy.peek()}: all robots stand; press Release, and they may move again`, "warning");
  if (now === "ready" && (before === "stopped" || before === "braking")) say("robots may move again", "good");
  if (now === "ready") mine.value = false;
  before = now;
});
