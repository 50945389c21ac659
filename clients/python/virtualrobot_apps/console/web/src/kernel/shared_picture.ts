// The settings of the picture that all viewers have, as the kernel keeps them.
import { signal } from "@preact/signals";
import type { View } from "../generated/virtualrobot/v1/view_pb";
import { attempt } from "./messages";
import { views } from "./services";

export const picture = signal<View | undefined>(undefined);

const PATHS = { jointAxes: "joint_axes", boundingBoxes: "bounding_boxes" } as const;
export type Aid = keyof typeof PATHS;

/** Shows the axes of a robot's joints, or the box around a node, for everybody, or hides them. */
export async function toggle(aid: Aid, name: string): Promise<void> {
  const before = picture.peek()?.[aid] ?? [], next = before.includes(name) ? before.filter((one) => one !== name) : [...before, name];
  await attempt(views.updateView({ view: { [aid]: next }, updateMask: { paths: [PATHS[aid]] } }));
}
