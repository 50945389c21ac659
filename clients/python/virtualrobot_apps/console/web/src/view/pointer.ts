// What clicks in the view do: select, look at what is selected, pick an axis, and, by the right button, open a node's menu.
import { Raycaster, Vector2 } from "three";
import { nodeMenu } from "../kernel/shown";
import * as world from "../kernel/world";
import { pickAxis, picking } from "./jointing";
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
  const area = view.canvas.getBoundingClientRect();
  const x = (2 * (event.clientX - area.left)) / area.width - 1, y = 1 - (2 * (event.clientY - area.top)) / area.height;
  const ray = new Raycaster();
  ray.setFromCamera(new Vector2(x, y), view.observer.camera);
  const hit = view.solids.hit(ray), found = hit?.name ?? "";
  if (picking.peek() && event.button === 0) {
    pickAxis(view, hit);
    return;
  }
  const isLink = world.items.peek().get(found)?.kind === "link";
  const name = isLink && !event.altKey ? world.robotOf(found) : found;
  world.selected.value = name;
  if (world.items.peek().get(name)?.kind === "robot") world.chosen.value = name;
  if (event.button === 2 || event.type === "contextmenu") {
    nodeMenu.value = { name: name || "world", part: isLink ? found : "", x: event.clientX, y: event.clientY };
  }
}
