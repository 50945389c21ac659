// What clicks in the view do: select, look at what is selected, pick an axis, and, by the right button, open a node's menu.
import { nodeMenu } from "../kernel/shown";
import * as world from "../kernel/world";
import { asked } from "./finding";
import { pickAxis, picking } from "./jointing";
import { pointerRay } from "./pointing";
import type { Viewport } from "./viewport";

const CLICK_PIXELS = 4;

/** Has clicks in a view heard from now on. */
export function hearPointer(view: Viewport): void {
  let down: PointerEvent | undefined;
  view.canvas.addEventListener("pointerdown", (event) => (down = event));
  view.canvas.addEventListener("pointerup", (event) => {
    const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PIXELS;
    if (still && !view.gizmo.dragging && !view.nodeHandle.dragging && !view.observer.axes.handleClick(event)) pick(view, event);
    view.invalidate();
  });
  // By a finger that stays; the right button is heard when it goes up, since it shifts the view while it is held.
  view.canvas.addEventListener("contextmenu", (event) => (event as PointerEvent).pointerType === "touch" && pick(view, event));
  view.canvas.addEventListener("dblclick", () => world.selected.value && view.frame(world.selected.value));
}

/** Selects what is under the pointer: of a robot the whole, with Alt the link. */
function pick(view: Viewport, event: MouseEvent): void {
  const hit = view.solids.hit(pointerRay(view, event)), found = hit?.name ?? "";
  if (picking.peek() && event.button === 0) {
    pickAxis(view, hit);
    return;
  }
  if (asked.peek() && event.button === 0) return;
  const isLink = world.items.peek().get(found)?.kind === "link";
  const name = isLink && !event.altKey ? world.robotOf(found) : found;
  world.selected.value = name;
  if (world.items.peek().get(name)?.kind === "robot") world.chosen.value = name;
  if (event.button === 2 || event.type === "contextmenu") {
    nodeMenu.value = { name: name || "world", part: isLink ? found : "", x: event.clientX, y: event.clientY };
  }
}
