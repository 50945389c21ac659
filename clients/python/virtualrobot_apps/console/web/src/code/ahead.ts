// What is planned of the robot's motion while the program runs: the way of its tool, and a ghost where each move ends.
import { ofArray, rowsOf } from "../kernel/arrays";
import type { Goal } from "../kernel/goal";
import { motions } from "../kernel/services";
import { states } from "../kernel/world";
import { evenly, swept } from "../view/postures";
import { showSpans } from "../view/spans";

const OWNER = "look-ahead";
const COLOR = "#38bdf8";
const SAMPLE_SECONDS = 0.05;
/** Numbers of a pose: a position, and a quaternion. */
const POSE = 7;

/** What the way is of, and the ghosts; "" for none. */
let drawn = "", ghosts = "";

/** Shows what the kernel has planned of the motion of a robot by now; nothing where none is. */
export async function showAhead(robot: string): Promise<void> {
  const [motionId] = states.peek().get(robot)?.motionIds ?? [];
  // One that ends meanwhile, or has no plan, such as a stream of setpoints, is refused.
  const said = motionId && (await motions.planMotion({ motionId, sampleSeconds: SAMPLE_SECONDS }).catch(() => undefined));
  const moved = said && said.robots.find((one) => one.robot === robot);
  if (!said || !moved) return hideAhead();
  const steps = ofArray(said.steps!), rows = rowsOf(ofArray(moved.positions!), moved.jointNames.length);
  const way = `${motionId} ${rows.length} ${rows[0]?.join()}`;
  if (way === drawn) return;
  drawn = way;
  const points = rowsOf(ofArray(moved.worldTTcp!), POSE).map(([x, y, z]) => ({ x, y, z }));
  showSpans(OWNER, points.slice(1).map((to, place) => ({ from: points[place], to, color: COLOR })));
  const ends: Goal[] = [];
  steps.forEach((step, place) => {
    if (step === steps[place + 1] || rows.length === 1) return;
    ends.push({ robot, jointPositions: Object.fromEntries(moved.jointNames.map((name, column) => [name, rows[place][column]])) });
  });
  const shown = `${motionId} ${[...new Set(steps)].join()}`;
  if (shown === ghosts) return;
  ghosts = shown;
  swept.value = evenly(ends);
}

export function hideAhead(): void {
  if (!drawn) return;
  drawn = ghosts = "";
  showSpans(OWNER, []);
  swept.value = [];
}
