// Robots that this page has leased, so that nobody else moves them, until it gives them back or is gone.
import { signal } from "@preact/signals";
import { say } from "./messages";
import { calls, leases } from "./services";
import { wordsOf } from "./words";

/** The tokens of this page's leases, by robot. All its calls carry them. */
const tokens = signal<ReadonlyMap<string, string>>(new Map());

export const isLeasedHere = (robot: string) => tokens.value.has(robot);

/** Leases a robot, or takes it over from whoever has leased it: its motions stop then. */
export async function lease(robot: string, take = false): Promise<void> {
  try {
    const { token } = await (take ? leases.takeLease({ robots: [robot] }) : leases.acquireLease({ robots: [robot] }));
    void keep(robot, token);
  } catch (error) {
    say(wordsOf(error), "error");
  }
}

/** Lets others move a robot again; what it does goes on. */
export async function giveBack(robot: string): Promise<void> {
  const token = tokens.peek().get(robot);
  carry(robot, undefined);
  if (token) await leases.releaseLease({ token }).catch(() => {}); // it has ended already
}

/** Holds a lease until it ends, and tells why it did unless it was given back. */
async function keep(robot: string, token: string): Promise<void> {
  carry(robot, token);
  let why = "";
  try {
    for await (const { reason } of leases.keepLeaseAlive({ token })) why = reason;
  } catch (error) {
    why = wordsOf(error);
  }
  if (tokens.peek().get(robot) !== token) return;
  carry(robot, undefined);
  say(`${robot} is not leased any more: ${why}`, "warning");
}

function carry(robot: string, token: string | undefined): void {
  const next = new Map(tokens.peek());
  if (token) next.set(robot, token);
  else next.delete(robot);
  tokens.value = next;
  calls.headers["virtualrobot-lease"] = [...next.values()].join(",");
}
