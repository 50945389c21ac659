/**
 * The picking program in TypeScript: an arm measures a part, picks it up, swings it into a post, and is told of that.
 *
 * Which kernel: VIRTUALROBOT_ADDRESS (default 127.0.0.1:50500) and VIRTUALROBOT_TOKEN (none for `--no-token`).
 */

import { readFile } from "node:fs/promises";
import { alongLine, ended, given, move, start, toJoints, toPose, worldTNode } from "./arm.js";
import type { Pose } from "./arm.js";
import { float32s } from "./arrays.js";
import { CollisionService } from "./generated/virtualrobot/v1/collision_pb.js";
import { ErrorReason } from "./generated/virtualrobot/v1/errors_pb.js";
import { KernelService } from "./generated/virtualrobot/v1/kernel_pb.js";
import { DisconnectPolicy, MotionPhase, MotionService } from "./generated/virtualrobot/v1/motion_pb.js";
import { SceneService } from "./generated/virtualrobot/v1/scene_pb.js";
import { SensorService } from "./generated/virtualrobot/v1/sensor_pb.js";
import { Kernel, Refusal } from "./kernel.js";

const ARM = { name: "arm" };

/** A goal in the world, in meters, with the tool pointing down. */
function above(z: number): Pose {
  return { position: { x: 0.5, z }, orientation: { x: Math.SQRT1_2, y: Math.SQRT1_2 } };
}

async function main(kernel: Kernel, scene: string): Promise<void> {
  const info = await kernel.call(KernelService.method.getInfo, {});
  console.log(`kernel: ${info.apiVersion}`);
  await kernel.call(SceneService.method.loadScene, { text: scene });
  console.log(`measured: ${await measured(kernel)} m`);

  const first = toPose(ARM, above(0.2));
  const plan = await kernel.call(MotionService.method.planMotion, { spec: { moves: [first] } });
  console.log(`planned: ${plan.durationSeconds.toFixed(2)} s`);
  const moved = await move(kernel, first);
  console.log(`moved: ${MotionPhase[moved.phase]}`);

  await move(kernel, alongLine(ARM, above(0.08)));
  const pick = { case: "pickPart", value: { robot: "arm", part: "part" } } as const;
  await kernel.call(SceneService.method.apply, { commands: [{ command: pick }] });
  await move(kernel, alongLine(ARM, above(0.28)));
  const [, , height] = await worldTNode(kernel, "part");
  console.log(`picked: the part is at ${given(height, "height").toFixed(2)} m`);
  console.log(`measured: ${await measured(kernel)} m`);

  await swing(kernel);
  await misspell(kernel);
}

/** Returns what the eye measures, in meters. */
async function measured(kernel: Kernel): Promise<string> {
  const { reading } = await kernel.call(SensorService.method.readSensor, { sensor: "eye" });
  const found = given(reading, "reading").reading;
  if (found.case !== "range") throw new Error("the eye is no range sensor");
  const [meters] = float32s(given(found.value.distances, "distances"));
  return given(meters, "distance").toFixed(2);
}

/** Turns the arm until the part meets the post, prints what touches, and lets the arm come to its goal. */
async function swing(kernel: Kernel): Promise<void> {
  const watch = new AbortController();
  const reports = kernel.watch(CollisionService.method.watchCollisions, {}, watch.signal);
  await reports.next(); // what touches now
  // Nobody watches the swing itself until it has touched something.
  const aside = toJoints(ARM, { lbr_iiwa_joint_1: Math.PI / 2 });
  const swung = await start(kernel, [aside], DisconnectPolicy.CONTINUE);
  for await (const { events } of reports) {
    const begun = events.map(({ what }) => what).find((what) => what.case === "begun");
    if (begun?.case !== "begun") continue;
    const { first, second } = given(begun.value.pair, "pair");
    console.log(`touching: ${[first, second].sort().join(" and ")}`);
    break;
  }
  watch.abort();
  await ended(kernel, swung);
}

/** Asks for a joint that is not there, and prints how that is refused. */
async function misspell(kernel: Kernel): Promise<void> {
  try {
    await move(kernel, toJoints(ARM, { lbr_iiwa_jiont_4: 0.5 }));
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    console.log(`refused: ${ErrorReason[error.reason]}, nearest is ${error.metadata["nearest"]}`);
  }
}

const kernel = new Kernel(process.env["VIRTUALROBOT_ADDRESS"] ?? "127.0.0.1:50500", process.env["VIRTUALROBOT_TOKEN"]);
try {
  const [, , file] = process.argv;
  await main(kernel, await readFile(file ?? "cell.yaml", "utf8"));
} catch (error) {
  console.error(error instanceof Error ? `${error.name}: ${error.message}` : error);
  process.exitCode = 1;
} finally {
  kernel.close();
}
