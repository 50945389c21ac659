// Buttons that do something for as long as they are held.
import { useSignal } from "@preact/signals";
import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";

/** Tells if a button is held, by pointer or by Enter, with what listens to it; `begin` and `end` come in turns. */
export function useHeld(begin: () => void, end: () => void) {
  const held = useSignal(false);
  const down = () => {
    if (held.peek()) return;
    held.value = true;
    begin();
  };
  const up = () => {
    if (held.peek()) end();
    held.value = false;
  };
  const listeners = {
    onPointerDown: (event: TargetedPointerEvent<HTMLButtonElement>) => {
      if (event.button !== 0) return;
      event.currentTarget.setPointerCapture(event.pointerId);
      down();
    },
    onPointerUp: up,
    onLostPointerCapture: up,
    onBlur: up,
    onContextMenu: (event: Event) => event.preventDefault(),
    onKeyDown: (event: TargetedKeyboardEvent<HTMLButtonElement>) => event.key === "Enter" && !event.repeat && down(),
    onKeyUp: (event: TargetedKeyboardEvent<HTMLButtonElement>) => event.key === "Enter" && up(),
  };
  return { held: held.value, listeners };
}
