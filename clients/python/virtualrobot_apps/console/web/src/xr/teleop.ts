// A hand that leads a robot's tool itself, without a plan, as long as it holds the ball: a pose for each picture of the
// headset. When none comes for 0.2 s, since the hand let go or isn't seen, or the page hangs, the kernel brakes the tool.
import { signal } from "@preact/signals";
import type { Matrix4 } from "three";
import { BusyPolicy, JogFrame, SetpointMode } from "../generated/virtualrobot/v1/motion_pb";
import { goal } from "../kernel/goal";
import { MOVING, TURNING } from "../kernel/leads";
import { expectMotion } from "../kernel/own_motions";
import { motions } from "../kernel/services";
import { forPeople, wordsOf } from "../kernel/words";
import { fixed, orientationOf, positionOf } from "../parts/numbers";
import { poseOf } from "../view/poses";
import { proposal } from "./proposal";

/** Whether the ball leads the tool; else it proposes. */
export const leads = signal(false);
/** What there is to say of what is led. */
export const ledWords = signal("");

const TIMEOUT_SECONDS = 0.2;

/** Poses as setpoints: x, y, z in m, and a quaternion x, y, z, w. */
function valuesOf(pose: Matrix4): number[] {
  const there = poseOf(pose), { x, y, z, w } = orientationOf(there);
  return [...positionOf(there), x, y, z, w];
}

class Lead {
  #values: number[] | undefined;
  #isOver = false;
  #wake = () => {};

  constructor(private readonly robot: string) {
    void this.#run();
  }

  show(pose: Matrix4): void {
    this.#values = valuesOf(pose);
    this.#wake();
  }

  end(): void {
    this.#isOver = true;
    this.#wake();
  }

  async #run(): Promise<void> {
    const tell = expectMotion();
    let asked: number[] = [], reason = "";
    const poses = this.#poses((values) => (asked = values));
    try {
      for await (const { motion, positions, heldBy } of motions.streamSetpoints(poses)) {
        tell(motion?.id);
        reason = motion?.endReason ?? "";
        const behind = Math.hypot(...[0, 1, 2].map((axis) => positions[axis] - asked[axis]));
        if (!this.#isOver) ledWords.value = `${fixed(1000 * behind, 0)} mm behind${heldBy && `, ${heldBy === "singularity" ? "a singularity is near" : `${heldBy} holds it up`}`}`;
      }
      ledWords.value = this.#isOver ? "" : forPeople(reason);
    } catch (error) {
      ledWords.value = this.#isOver ? "" : wordsOf(error);
    } finally {
      tell();
      this.#isOver = true;
    }
  }

  async *#poses(told: (values: number[]) => void) {
    const target = {
      robot: this.robot, mode: SetpointMode.TOOL_POSE, frame: JogFrame.NODE, node: "world", busyPolicy: BusyPolicy.REJECT,
      timeoutSeconds: TIMEOUT_SECONDS, maxVelocityMetersPerSecond: MOVING, maxRotationVelocityRadiansPerSecond: TURNING,
    };
    let isFirst = true;
    while (!this.#isOver) {
      const values = this.#values;
      this.#values = undefined;
      if (values) {
        told(values);
        yield isFirst ? { target, values } : { values };
        isFirst = false;
      } else await new Promise<void>((resolve) => (this.#wake = resolve));
    }
  }
}

class Teleop {
  #lead?: Lead;

  /** Has the ball lead the tool from now on, or propose again; what is proposed here is dropped. */
  toggle(): void {
    this.end();
    if (proposal.isBegun) return;
    proposal.reject("a hand leads the tool");
    goal.clear();
    ledWords.value = "";
    leads.value = !leads.peek();
  }

  /** Leads the tool to a pose in the world; to be told once in each frame, also where the hand is still. */
  lead(robot: string, pose: Matrix4): void {
    (this.#lead ??= new Lead(robot)).show(pose);
  }

  /** Lets go: the tool comes to rest. */
  end(): void {
    this.#lead?.end();
    this.#lead = undefined;
  }
}

export const teleop = new Teleop();
