// What the pointer does in the view: clicks select, or are taken by who aims; two look at what is selected, and the right button opens a node's menu.
import { effect, untracked } from "@preact/signals";
import { nodeMenu } from "../kernel/shown";
import * as world from "../kernel/world";
import { aim } from "./aiming";
import { pointerRay } from "./pointing";
import type { Viewport } from "./viewport";

const CLICK_PIXELS = 4;

/** Has the pointer in a view heard from now on. */
export function hearPointer(view: Viewport): void {
  const { canvas } = view;
  let down: PointerEvent | undefined;
  canvas.addEventListener("pointerdown", (event) => (down = event));
  canvas.addEventListener("pointerup", (event) => {
    const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PIXELS;
    if (still && !view.gizmo.dragging && !view.nodeHandle.dragging && !view.observer.axes.handleClick(event)) click(view, event);
    view.invalidate();
  });
  canvas.addEventListener("pointermove", (event) => event.buttons === 0 && aim.peek()?.over(view, event));
  canvas.addEventListener("pointerleave", () => aim.peek()?.over(view, undefined));
  // By a finger that stays; the right button is heard when it goes up, since it shifts the view while it is held.
  canvas.addEventListener("contextmenu", (event) => (event as PointerEvent).pointerType === "touch" && select(view, event));
  canvas.addEventListener("dblclick", () => !aim.peek() && world.selected.value && view.frame(world.selected.value));
  let before = aim.peek();
  effect(() => {
    const now = aim.value;
    untracked(() => before?.over(view, undefined));
    before = now;
    canvas.style.cursor = now ? "crosshair" : "";
  });
}

function click(view: Viewport, event: PointerEvent): void {
  const one = aim.peek();
  if (one && event.button === 0) one.click(view, event);
  else select(view, event);
}

/** Selects what is under the pointer: of a robot the whole, with Alt the link. */
function select(view: Viewport, event: MouseEvent): void {
  const found = view.solids.hit(pointerRay(view, event))?.name ?? "";
  const isLink = world.items.peek().get(found)?.kind === "link";
  const name = isLink && !event.altKey ? world.robotOf(found) : found;
  world.selected.value = name;
  if (world.items.peek().get(name)?.kind === "robot") world.chosen.value = name;
  if (event.button === 2 || event.type === "contextmenu") {
    nodeMenu.value = { name: name || "world", part: isLink ? found : "", x: event.clientX, y: event.clientY };
  }
}
