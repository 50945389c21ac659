/**
 * The README's ten lines in TypeScript: load an arm, move it, and watch it move.
 *
 * Which kernel: VIRTUALROBOT_ADDRESS (default 127.0.0.1:50500) and VIRTUALROBOT_TOKEN (none for `--no-token`).
 */

import { alongLine, given, loadArm, move, positions, toJoints, toPose, worldTNode } from "./arm.js";
import type { Arm } from "./arm.js";
import { ErrorReason } from "./generated/virtualrobot/v1/errors_pb.js";
import { KernelService } from "./generated/virtualrobot/v1/kernel_pb.js";
import { RobotService } from "./generated/virtualrobot/v1/robot_pb.js";
import { Kernel, Refusal } from "./kernel.js";

const API_VERSION = "virtualrobot.v1";

async function main(kernel: Kernel): Promise<void> {
  const info = await kernel.call(KernelService.method.getInfo, {});
  if (info.apiVersion !== API_VERSION) throw new Error(`this kernel speaks ${info.apiVersion}, not ${API_VERSION}`);

  const arm = await loadArm(kernel, "package://pybullet_data/kuka_iiwa/model.urdf", "arm");
  const stop = new AbortController();
  await Promise.all([
    printStates(kernel, arm, stop.signal),
    work(kernel, arm).finally(() => stop.abort()),
  ]);
  console.log(`joints: ${numbers(await positions(kernel, arm))}`);
  console.log(`flange: ${numbers(await worldTNode(kernel, arm.flange))}`);

  await misspell(kernel, arm);
}

/** The README's three moves. */
async function work(kernel: Kernel, arm: Arm): Promise<void> {
  await move(kernel, toJoints(arm, named(arm, [0, 0.5, 0, -1.2, 0, 0.8, 0]))); // radians
  const pointingDown = { x: 1 }; // a quaternion: half a turn about x
  await move(kernel, toPose(arm, { position: { x: 0.5, y: 0.1, z: 0.5 }, orientation: pointingDown })); // meters
  await move(kernel, alongLine(arm, { position: { z: 0.1 } }, arm.flange)); // 10 cm straight along its axis
}

/** Prints the robot's state again and again, until `signal` is aborted. */
async function printStates(kernel: Kernel, arm: Arm, signal: AbortSignal): Promise<void> {
  const request = { names: [arm.name], readMask: { paths: ["positions"] }, maxRateHertz: 10 };
  for await (const { stamp, robots } of kernel.watch(RobotService.method.watchRobotStates, request, signal)) {
    const { tick } = given(stamp, "stamp"); // a bigint
    for (const robot of robots) console.log(`tick ${tick}: ${numbers(robot.positions)}`);
  }
}

/** Asks for a joint that is not there, and prints how that is refused. */
async function misspell(kernel: Kernel, arm: Arm): Promise<void> {
  try {
    await move(kernel, toJoints(arm, { lbr_iiwa_jiont_4: 0.5 }));
  } catch (error) {
    if (!(error instanceof Refusal && error.reason === ErrorReason.UNKNOWN_NAME)) throw error;
    console.log(`refused: ${error.code} ${ErrorReason[error.reason]}: ${error.message}`);
    console.log(`nearest: ${error.metadata["nearest"]}`);
  }
}

function named(arm: Arm, values: readonly number[]): Record<string, number> {
  if (values.length !== arm.jointNames.length) throw new Error(`${arm.name} has ${arm.jointNames.length} joints`);
  return Object.fromEntries(arm.jointNames.map((name, index) => [name, values[index] ?? 0]));
}

function numbers(values: Iterable<number>): string {
  return [...values].map((value) => value.toFixed(6)).join(" ");
}

const kernel = new Kernel(process.env["VIRTUALROBOT_ADDRESS"] ?? "127.0.0.1:50500", process.env["VIRTUALROBOT_TOKEN"]);
try {
  await main(kernel);
} catch (error) {
  console.error(error instanceof Error ? `${error.name}: ${error.message}` : error);
  process.exitCode = 1;
} finally {
  kernel.close();
}
