// Tabs and choices by the arrow keys, as people who work by keys expect them.

/** Gives the focus to the next or previous one of those in a bar, round and round; returns it. */
export function walkAcross(event: KeyboardEvent): HTMLElement | undefined {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return undefined;
  const all = [...(event.currentTarget as HTMLElement).querySelectorAll<HTMLElement>('[role="tab"], [role="radio"]')];
  const at = all.indexOf(document.activeElement as HTMLElement);
  const next = all[(at + step + all.length) % all.length];
  event.preventDefault();
  next?.focus();
  return next;
}
