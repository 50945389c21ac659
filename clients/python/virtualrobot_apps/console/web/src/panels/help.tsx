// Help where a person is: what the panel is for that was used last, and the page's keys.
import { signal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { ABOUT, helps, KEYS } from "../kernel/help";
import { opened, shownBelow, shownRight } from "../kernel/shown";
import { Icon } from "../parts/icons";

const PLACES = { ".left": "left", ".right": "right", ".bottom": "bottom", ".top": "top", ".view": "view" };

/** Where the pointer or the focus was last, but for help itself. */
const place = signal("view");

for (const event of ["pointerdown", "focusin"]) {
  addEventListener(event, ({ target }) => {
    if (!(target instanceof Element) || target.closest("#help, .help")) return;
    const found = Object.entries(PLACES).find(([selector]) => target.closest(selector));
    if (found) place.value = found[1];
  }, { capture: true });
}

export function HelpButton() {
  return <button type="button" class="tool" id="help" aria-pressed={helps.value} title="Help for where you are (F1)" onClick={() => (helps.value = !helps.peek())}><Icon name="circle-help" /></button>;
}

/** `left` is the panel that is shown on the left. */
export function Help({ left }: { left: string }) {
  const close = useRef<HTMLButtonElement>(null);
  const before = useRef<Element | null>(null);
  useLayoutEffect(() => {
    if (!helps.value) return;
    before.current = document.activeElement;
    close.current?.focus();
    return () => before.current instanceof HTMLElement && before.current.focus();
  }, [helps.value]);
  if (!helps.value) return null;
  const shown: Record<string, string> = { left, right: shownRight.value, bottom: shownBelow.value, view: opened.value || "view", top: "top" };
  const { name, says } = ABOUT[shown[place.value]];
  return (
    <section class="float help" role="dialog" aria-label="Help" onKeyDown={(event) => event.key === "Escape" && (event.stopPropagation(), (helps.value = false))}>
      <div class="row"><h2 class="grow">{name}</h2><button ref={close} type="button" class="tool small" title="Close (Esc)" onClick={() => (helps.value = false)}><Icon name="x" size={14} /></button></div>
      {says.map((words) => <p key={words} class="words">{words}</p>)}
      <p class="muted">Lengths are mm and angles degrees, with a comma or a point. What a button does, its key and unit, is told where the pointer rests on it.</p>
      <dl>{KEYS.map(([keys, what]) => <div key={keys} class="row"><dt>{keys}</dt><dd class="muted">{what}</dd></div>)}</dl>
    </section>
  );
}
