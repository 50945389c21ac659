// Questions about the world as it is, asked again as it changes, for as long as somebody looks at the answer.
import { effect } from "@preact/signals";
import { connection, hearers, steps } from "./world";

const APART_MS = 200;

/** Asks at once and then whenever the world has changed, at most five times a second; returns what ends that. */
export function askedAnew(ask: () => Promise<unknown>): () => void {
  let changed = true, over = false;
  const hear = () => void (changed = true);
  const sets = [hearers.poses, hearers.structure, hearers.states];
  for (const set of sets) set.add(hear);
  const unheard = effect(() => {
    void steps.value;
    hear();
  });
  const go = async () => {
    while (!over) {
      if (changed && connection.peek() === "connected") {
        changed = false;
        await ask();
      }
      await new Promise((resolve) => setTimeout(resolve, APART_MS));
    }
  };
  void go();
  return () => {
    over = true;
    unheard();
    for (const set of sets) set.delete(hear);
  };
}
