// One line below the field whose text is no number: why, and what would be one.
import { signal } from "@preact/signals";
import { whyNot } from "./numbers";

interface Told {
  field: HTMLInputElement;
  why: string;
}

const WIDTH = 236;

const told = signal<Told | undefined>(undefined);

/** Says why a field's text is no number, or `why` of its own; with "" that all is well there. */
export function tellNumber(field: HTMLInputElement, why = whyNot(field.value)): void {
  if (why) told.value = { field, why };
  else if (told.peek()?.field === field) told.value = undefined;
}

/** The line, in the page's frame: no panel cuts it off. */
export function WrongNumber() {
  const { field, why } = told.value ?? {};
  if (!field?.isConnected) return null;
  const { left, top, bottom } = field.closest(".field")!.getBoundingClientRect();
  const low = bottom > innerHeight - 40;
  const place = { left: `${Math.max(4, Math.min(left, innerWidth - WIDTH))}px`, [low ? "bottom" : "top"]: `${(low ? innerHeight - top : bottom) + 3}px` };
  return <div class="float why" role="alert" id="why" style={place}>{why}</div>;
}

// Who scrolls takes the field away from its line.
addEventListener("scroll", () => (told.value = undefined), { capture: true });
