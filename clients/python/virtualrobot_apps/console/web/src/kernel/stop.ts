// STOP: for everybody, always, by two ways at once, and it tells when the robots stand.
import { effect, signal } from "@preact/signals";
import { MotionService } from "../generated/virtualrobot/v1/motion_pb";
import { letGo } from "./jog";
import { attempt, say } from "./messages";
import { drivers as driverService, motions } from "./services";
import { cell, drivers, moving } from "./world";

export type Stopping = "ready" | "asked" | "braking" | "stopped";

/** How far the last STOP is; "stopped" is shown for a while. */
export const stopping = signal<Stopping>("ready");

const SHOWN_MS = 2500;
const REASON = "STOP in the console";
let again: ReturnType<typeof setTimeout> | undefined;

/** Stops all robots on their paths, by the page's socket and by a request of its own, whichever gets through first. */
export async function stop(): Promise<void> {
  clearTimeout(again);
  letGo();
  stopping.value = "asked";
  const address = `/${MotionService.typeName}/Stop`;
  const asked = { method: "POST", headers: { "content-type": "application/json", "client-name": "console" }, body: "{}" };
  const byRequest = fetch(address, { ...asked, keepalive: true }).then(async (reply) => {
    if (!reply.ok) throw new Error(((await reply.json()) as { message: string }).message);
  });
  const bySocket = motions.stop({});
  if (drivers.peek().length > 0) void attempt(driverService.stopCell({ reason: REASON }));
  try {
    await Promise.any([bySocket, byRequest]);
    stopping.value = "braking";
  } catch (error) {
    stopping.value = "ready";
    const [first] = (error as AggregateError).errors as Error[];
    say(`STOP was not heard: ${first.message}. Use the robot's own stop.`, "error");
  }
}

/** Lets real robots move again after a STOP; nothing moves by that. */
export async function release(): Promise<void> {
  await attempt(driverService.releaseCell({}));
}

effect(() => {
  if (stopping.value !== "braking" || moving.value) return;
  stopping.value = "stopped";
  say("stopped: all robots stand", "warning");
  again = setTimeout(() => (stopping.value = "ready"), SHOWN_MS);
});

/** Returns whether real robots are stopped until somebody releases them. */
export function isLatched(): boolean {
  return cell.value?.stopped ?? false;
}
