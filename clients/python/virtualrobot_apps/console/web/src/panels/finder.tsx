// The finder (Ctrl-K): whatever the page can do, by its name, in panels that aren't shown too, and the nodes of the cell.
import { signal, type Signal } from "@preact/signals";
import { h, render } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { ABOUT } from "../kernel/help";
import { items, selected } from "../kernel/world";
import { Icon, KindIcon } from "../parts/icons";
import type { Tab } from "../parts/tabs";

const MOST_SHOWN = 12;
/** What has a name and can be pressed; a jog's button moves a robot as long as it is held, which nobody holds here. */
const PRESSED = 'button:not(:disabled):not(.jog), [role="tab"]';

interface Command {
  name: string;
  place: string;
  kind?: string;
  /** What a panel is for: it is found by these words, too, after what is called so. */
  about?: string;
  run: () => void;
}

/** Panels of which one is shown. */
export interface Group {
  chosen: Signal<string>;
  tabs: readonly Tab[];
}

interface Search {
  commands: readonly Command[];
  words: string;
  at: number;
}

const purposes = new Map(Object.values(ABOUT).map(({ name, says }) => [name, says.join(" ")]));
const search = signal<Search | undefined>(undefined);
let before: Element | null = null;

export function openFinder(groups: readonly Group[]): void {
  before = document.activeElement;
  search.value = { commands: [...buttons(), ...nodes(), ...groups.flatMap(unseen)], words: "", at: 0 };
}

function close(): void {
  search.value = undefined;
  if (before instanceof HTMLElement) before.focus();
}

function* buttons(): Iterable<Command> {
  const known = new Set<string>();
  for (const one of document.querySelectorAll<HTMLElement>(PRESSED)) {
    const name = nameOf(one);
    const place = one.closest("aside, section, header, footer, nav, [role=tabpanel], [role=toolbar]")?.ariaLabel ?? "";
    if (!name || known.has(`${place}/${name}`)) continue;
    known.add(`${place}/${name}`);
    const run = () => one.click();
    if (one.getAttribute("role") !== "tab") yield { name, place, run };
    else yield { name: `Show ${name}`, place, about: purposes.get(name), run };
  }
}

function nameOf(one: HTMLElement): string {
  if (one.getAttribute("role") === "radio") return `${one.closest('[role="radiogroup"]')?.ariaLabel}: ${one.textContent}`;
  return (one.ariaLabel || one.title || one.textContent || "").trim().replace(/\s+/g, " ");
}

/** Returns what panels that aren't shown would have: each is made for a moment, beside the page, without its effects. */
function unseen({ chosen, tabs }: Group): Command[] {
  return tabs.filter(({ id }) => id !== chosen.peek()).flatMap(({ id, name: place, panel }) => {
    const host = document.createElement("div");
    render(h(panel, null), host);
    const names = new Set([...host.querySelectorAll<HTMLElement>(PRESSED)].map(nameOf).filter(Boolean));
    render(null, host);
    return [...names].map((name) => ({ name, place, run: () => ((chosen.value = id), pressed(name)) }));
  });
}

/** Presses what has this name, once the panel that has it is there. */
function pressed(name: string): void {
  requestAnimationFrame(() => [...document.querySelectorAll<HTMLElement>(PRESSED)].find((one) => nameOf(one) === name)?.click());
}

function* nodes(): Iterable<Command> {
  for (const { name, kind } of items.peek().values()) {
    if (kind !== "world") yield { name, place: `Select, ${kind}`, kind, run: () => (selected.value = name) };
  }
}

/** Returns the commands that have all words in their names, first those whose name begins with the first; then panels that are about them. */
function found({ commands, words }: Search): Command[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const has = (text: string) => wanted.every((word) => text.toLowerCase().includes(word));
  const fit = commands.filter(({ name, place }) => has(`${name} ${place}`));
  const begins = ({ name }: Command) => (wanted.length && name.toLowerCase().startsWith(wanted[0]) ? 0 : 1);
  const others = commands.filter((one) => !fit.includes(one) && has(one.about ?? ""));
  return [...fit.sort((a, b) => begins(a) - begins(b)), ...others].slice(0, MOST_SHOWN);
}

export function Finder() {
  const field = useRef<HTMLInputElement>(null);
  const now = search.value;
  // At once: what is typed right after Ctrl-K is meant for the field.
  useLayoutEffect(() => field.current?.focus(), [now === undefined]);
  if (!now) return null;
  const shown = found(now);
  const at = Math.min(now.at, shown.length - 1);
  const run = (command: Command | undefined) => {
    if (!command) return;
    close();
    command.run();
  };
  const keys: Record<string, () => void> = {
    ArrowDown: () => (search.value = { ...now, at: Math.min(at + 1, shown.length - 1) }),
    ArrowUp: () => (search.value = { ...now, at: Math.max(at - 1, 0) }),
    Enter: () => run(shown[at]),
    Escape: close,
  };
  return (
    <div class="veil finding" onClick={close}>
      <div class="float finder" role="dialog" aria-label="Find a command or a node" onClick={(event) => event.stopPropagation()}>
        <label class="search">
          <Icon name="search" size={15} />
          <input ref={field} value={now.words} placeholder="What to do, or a node" role="combobox" aria-expanded="true"
            aria-label="Find a command or a node" aria-controls="found" aria-activedescendant={`found-${at}`}
            onInput={(event) => (search.value = { ...now, words: event.currentTarget.value, at: 0 })}
            onKeyDown={(event) => {
              if (!keys[event.key]) return;
              event.preventDefault();
              event.stopPropagation();
              keys[event.key]();
            }} />
        </label>
        <ul id="found" role="listbox" aria-label="What was found">
          {shown.map((command, place) => (
            <li key={`${command.place}/${command.name}`} id={`found-${place}`} role="option" aria-selected={place === at} onClick={() => run(command)}>
              {command.kind ? <KindIcon kind={command.kind} /> : <Icon name="chevron-right" size={15} color="var(--muted)" />}
              <span>{command.name}</span>
              <span class="muted">{command.place}</span>
            </li>
          ))}
          {shown.length === 0 && <li class="muted">Nothing here is called so.</li>}
        </ul>
      </div>
    </div>
  );
}
