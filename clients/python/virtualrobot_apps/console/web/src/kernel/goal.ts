// Where the chosen robot shall go: joints as sliders say, or the postures that reach where the handle was dragged.
import { computed, effect, signal } from "@preact/signals";
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import type { MotionSpecSchema } from "../generated/virtualrobot/v1/motion_pb";
import { ofArray } from "./arrays";
import { say } from "./messages";
import { run } from "./orders";
import { robots } from "./services";
import { forPeople, wordsOf } from "./words";
import { chosen } from "./world";

type AnyPose = MessageInitShape<typeof PoseSchema>;

export interface Goal {
  robot: string;
  /** Radians or meters by joint. */
  jointPositions: Record<string, number>;
}

export interface Branch extends Goal {
  /** As the kernel names it: its way, and full turns of joints, such as `right up noflip joint_6+1`. */
  name: string;
  /** The way without turns. */
  way: string;
}

export type Reach = "unknown" | "reached" | "unreachable";

export interface Off {
  meters: number;
  radians: number;
}

const TURN = / \S+[+-]\d+$/;

function namesOf(name: string): Pick<Branch, "name" | "way"> {
  let way = name;
  while (TURN.test(way)) way = way.replace(TURN, "");
  return { name, way };
}

class Goals {
  /** All postures that reach the wanted pose, the nearest first, and which of them is shown. */
  readonly branches = signal<readonly Branch[]>([]);
  readonly branch = signal(0);
  readonly reach = signal<Reach>("unknown");
  readonly explanation = signal("");
  /** How far the best posture is off what is out of reach. */
  readonly off = signal<Off>({ meters: 0, radians: 0 });
  readonly joints = signal<Goal | undefined>(undefined);
  readonly way = signal<"PTP" | "LIN">("PTP");
  readonly shown = computed<Goal | undefined>(() => this.joints.value ?? this.branches.value[this.branch.value]);
  /** The pose in the world that is wanted; undefined where joints are. */
  readonly pose = signal<AnyPose | undefined>(undefined);
  #asked: Promise<void> | undefined;
  #next: [string, AnyPose] | undefined;

  /** Wants one joint elsewhere; the others stay where they are, or are wanted already. */
  setJoint(robot: string, joint: string, position: number): void {
    const before = this.joints.peek();
    const kept = before?.robot === robot ? before.jointPositions : (this.branches.peek()[this.branch.peek()]?.jointPositions ?? {});
    this.#clearBranches();
    this.joints.value = { robot, jointPositions: { ...kept, [joint]: position } };
  }

  /** Wants all of these joints there. */
  show(robot: string, jointPositions: Record<string, number>): void {
    this.#clearBranches();
    this.joints.value = { robot, jointPositions };
  }

  /** Asks for the postures that have the tool centre point at a pose in the world; of quick questions the last one counts. */
  ask(robot: string, world_t_tcp: AnyPose): Promise<void> {
    this.#next = [robot, world_t_tcp];
    this.pose.value = world_t_tcp;
    return (this.#asked ??= this.#answer());
  }

  clear(): void {
    this.joints.value = undefined;
    this.#clearBranches();
  }

  /** Moves the robot to what is shown, once that is what was asked for last. */
  async go(): Promise<void> {
    await this.#asked;
    const goal = this.shown.peek();
    if (!goal) return;
    if (await run(this.motion(goal, 0.5)) && this.shown.peek() === goal) this.clear();
  }

  /** Returns the motion to a goal, at a part of the greatest speed. */
  motion({ robot, jointPositions }: Goal, speedFactor: number): MessageInitShape<typeof MotionSpecSchema> {
    const line = this.way.peek() === "LIN" && this.pose.peek() !== undefined;
    const move = line
      ? { case: "linear" as const, value: { goal: { referenceTTcp: this.pose.peek() } } }
      : { case: "pointToPoint" as const, value: { goal: { case: "joints" as const, value: { jointPositions } } } };
    return { moves: [{ robot, speedFactor, move }] };
  }

  get isPose(): boolean {
    return this.branches.value.length > 0;
  }

  async #answer(): Promise<void> {
    while (this.#next) {
      const [robot, pose] = this.#next;
      this.#next = undefined;
      try {
        await this.#solve(robot, pose);
      } catch (error) {
        say(wordsOf(error), "error");
      }
    }
    this.#asked = undefined;
  }

  async #solve(robot: string, pose: AnyPose): Promise<void> {
    const said = await robots.solveInverse({ robot, referenceTTcp: pose });
    // Nothing is wanted any more, or joints are.
    if (this.pose.peek() === undefined) return;
    const joints = said.jointNames, numbers = said.solutions ? ofArray(said.solutions) : new Float64Array();
    const found = Array.from({ length: joints.length ? numbers.length / joints.length : 0 }, (_, row) => ({
      robot,
      ...namesOf(said.configurations[row] || `posture ${row + 1}`),
      jointPositions: Object.fromEntries(joints.map((joint, place) => [joint, numbers[row * joints.length + place]])),
    }));
    this.joints.value = undefined;
    this.branch.value = 0;
    this.branches.value = found;
    this.reach.value = found.length > 0 ? "reached" : "unreachable";
    this.explanation.value = found.length > 0 ? "" : forPeople(said.explanation);
    this.off.value = { meters: said.positionErrorMeters, radians: said.rotationErrorRadians };
  }

  #clearBranches(): void {
    this.#next = undefined;
    this.pose.value = undefined;
    this.branches.value = [];
    this.branch.value = 0;
    this.reach.value = "unknown";
    this.explanation.value = "";
  }
}

export const goal = new Goals();

// A goal is of one robot.
effect(() => {
  void chosen.value;
  goal.clear();
});
