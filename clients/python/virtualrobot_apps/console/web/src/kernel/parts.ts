// Parts: which are held, and which a robot's tool may pick, place, and how far they are from it.
import type { MessageInitShape } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import type { CommandSchema } from "../generated/virtualrobot/v1/scene_pb";
import { say } from "./messages";
import { scenes } from "./services";
import { wordsOf } from "./words";
import { children, items, type Item } from "./world";

/** How far a part's origin may be from the tool centre point to be picked, as the kernel has it where no part is named. */
export const graspMeters = signal(0.2);

/** What parts are placed on. */
export const ground = signal("world");

/** Why the last pick or place was refused, in the kernel's words; "" where it was not. */
export const refused = signal("");

/** Fixes a part to the robot's chosen tool, where it is; "" is the nearest one. */
export async function pick(robot: string, part: string): Promise<void> {
  const held = await asked({ case: "pickPart", value: { robot, part, maxDistanceMeters: graspMeters.peek() } });
  if (held) say(`${robot} holds ${held.join(", ")}`, "good");
}

/** Lets a part go, "" all of them; it stays where it is, fixed to `ground`. */
export async function place(robot: string, part: string): Promise<void> {
  const parent = ground.peek();
  if (await asked({ case: "placePart", value: { robot, part, parent } })) say(`${robot} has placed ${part || "all"} on ${parent}`, "good");
}

/** Has a robot work with a tool of its, and a tool centre point of that; "" is its first one. */
export async function selectTool(robot: string, tool: string, toolCenterPoint = ""): Promise<void> {
  await asked({ case: "selectTool", value: { robot, tool, toolCenterPoint } });
}

/** Returns the parts that a tool holds. */
export function heldBy(tool: string): readonly Item[] {
  return (children.value.get(tool) ?? []).filter(({ kind }) => kind === "part");
}

/** Returns the tool that a node hangs on, at whatever depth; "" for none. */
export function holderOf(name: string): string {
  let item = items.value.get(name);
  while (item && item.kind !== "tool") item = items.value.get(item.parent);
  return item?.name ?? "";
}

/** Returns the parts that were picked; undefined when it is refused. */
async function asked(command: MessageInitShape<typeof CommandSchema>["command"]): Promise<readonly string[] | undefined> {
  try {
    const { pickedParts } = await scenes.apply({ commands: [{ command }] });
    refused.value = "";
    return pickedParts;
  } catch (error) {
    refused.value = wordsOf(error);
    say(refused.value, "error");
    return undefined;
  }
}
