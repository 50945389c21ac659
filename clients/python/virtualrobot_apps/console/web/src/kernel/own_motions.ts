// Motions that this page has begun, and who else moves the chosen robot.
import { computed, signal } from "@preact/signals";
import { StepKind } from "../generated/virtualrobot/v1/history_pb";
import { motions } from "./services";
import { personOf } from "./words";
import { chosen, states, steps } from "./world";

const own = signal<ReadonlySet<string>>(new Set());
/** How many motions of this page have been asked for whose names aren't known yet. */
const asked = signal(0);

/** Expects a motion of this page. What is returned is told its name, and with none that it doesn't come. */
export function expectMotion(): (id?: string) => void {
  let waits = true;
  asked.value++;
  return (id) => {
    if (id && !own.peek().has(id)) own.value = new Set(own.peek()).add(id);
    if (waits) asked.value--;
    waits = false;
  };
}

/** Starts a motion, which is this page's own from now on. */
export async function start(request: Parameters<typeof motions.startMotion>[0]) {
  const tell = expectMotion();
  try {
    const said = await motions.startMotion(request);
    tell(said.motion?.id);
    return said;
  } finally {
    tell();
  }
}

/** Who else moves the chosen robot; "" where nobody does. */
export const otherMover = computed(() => {
  const robot = chosen.value;
  const moved = states.value.get(robot)?.motionIds.some((id) => !own.value.has(id));
  if (!moved || asked.value > 0) return "";
  const began = steps.value.find(({ kind, label }) => kind === StepKind.MOTION && label.startsWith("started") && label.includes(`'${robot}'`));
  return began ? personOf(began.author) : "another program";
});
