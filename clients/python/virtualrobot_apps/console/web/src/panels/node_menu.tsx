// The menu of a node, by the right button in the tree or the view, or by the menu key: what can be done with it.
import { useLayoutEffect, useRef } from "preact/hooks";
import { isolate, isolated } from "../kernel/isolation";
import { saveNode } from "../kernel/loader";
import { say } from "../kernel/messages";
import { remove, setHidden, setLocked } from "../kernel/orders";
import { nodeMenu, shownRight } from "../kernel/shown";
import { items, selected, type Item } from "../kernel/world";
import { Icon, KindIcon } from "../parts/icons";
import { beginRenaming } from "./tree";
import { viewport } from "./view";

interface Entry {
  name: string;
  icon: string;
  keys?: string;
  run: () => void;
}

export function NodeMenu() {
  const asked = nodeMenu.value;
  const item = asked && items.value.get(asked.name);
  return asked && item ? <Entries item={item} {...asked} /> : null;
}

function Entries({ item, part, x, y }: { item: Item; part: string; x: number; y: number }) {
  const menu = useRef<HTMLDivElement>(null);
  const before = useRef(document.activeElement);
  /** Closes the menu; who has chosen something or left it by a key goes on where they were. */
  const leave = () => {
    nodeMenu.value = undefined;
    if (before.current instanceof HTMLElement) before.current.focus();
  };
  useLayoutEffect(() => {
    const { style, offsetWidth, offsetHeight } = menu.current!;
    style.left = `${Math.max(4, Math.min(x, innerWidth - offsetWidth - 4))}px`;
    style.top = `${Math.max(4, Math.min(y, innerHeight - offsetHeight - 4))}px`;
    menu.current!.querySelector<HTMLElement>("button")?.focus();
  }, [item.uid, x, y]);
  // At once, too: who clicks beside it does so before the next picture.
  useLayoutEffect(() => {
    const elsewhere = ({ target }: Event) => {
      if (!(target instanceof Node && menu.current?.contains(target))) nodeMenu.value = undefined;
    };
    const events = ["pointerdown", "wheel", "resize"];
    for (const event of events) addEventListener(event, elsewhere, { capture: true });
    return () => events.forEach((event) => removeEventListener(event, elsewhere, { capture: true }));
  }, []);
  return (
    <div ref={menu} class="float menu" role="menu" aria-label={item.name} data-keys="" onKeyDown={(event) => walk(event, leave)} onContextMenu={(event) => event.preventDefault()}>
      <h4><KindIcon kind={item.kind} icon={item.node.icon} /><span class="cut">{item.name}</span></h4>
      {entriesOf(item, part).map(({ name, icon, keys, run }) => (
        <button key={name} type="button" role="menuitem" onClick={() => (leave(), run())}>
          <Icon name={icon} size={15} />
          <span class="grow cut">{name}</span>
          {keys && <kbd>{keys}</kbd>}
        </button>
      ))}
    </div>
  );
}

function entriesOf({ name, kind, hidden, node }: Item, part: string): Entry[] {
  const look = { name: "Look at it", icon: "crosshair", keys: "F", run: () => viewport.current?.frame(kind === "world" ? "" : name) };
  const all = { name: "Show the whole cell", icon: "eye", keys: "I", run: () => (isolated.value = "") };
  const copied = { name: "Copy the name", icon: "copy", run: () => void copy(name) };
  if (kind === "world") return [look, ...(isolated.value ? [all] : []), copied];
  const entries: Entry[] = [
    look,
    ...(part ? [{ name: `Select ${part}`, icon: "link", keys: "Alt-click", run: () => (selected.value = part) }] : []),
    isolated.value === name ? all : { name: "Show it alone", icon: "scan-eye", keys: "I", run: () => isolate(name) },
    { name: hidden ? "Show it" : "Hide it", icon: hidden ? "eye" : "eye-off", run: () => void setHidden(name, !hidden) },
    { name: node.locked ? "Unlock it" : "Lock it", icon: "lock", run: () => void setLocked(name, !node.locked) },
    { name: "Properties", icon: "box", run: () => (shownRight.value = "properties") },
    { name: "Rename", icon: "pencil", keys: "F2", run: () => beginRenaming(name) },
    copied,
    { name: "Save as glTF", icon: "download", run: () => void saveNode(name, ".glb") },
    ...(kind === "robot" ? [{ name: "Save as URDF", icon: "download", run: () => void saveNode(name, ".urdf") }] : []),
  ];
  // A link goes with its robot.
  if (kind !== "link") entries.push({ name: "Delete", icon: "trash-2", keys: "Del", run: () => void remove(name) });
  return entries;
}

function walk(event: KeyboardEvent, leave: () => void): void {
  const entries = [...(event.currentTarget as HTMLElement).querySelectorAll<HTMLElement>("button")];
  const at = entries.indexOf(document.activeElement as HTMLElement), last = entries.length - 1;
  const to = { ArrowDown: at < last ? at + 1 : 0, ArrowUp: at > 0 ? at - 1 : last, Home: 0, End: last }[event.key];
  if (to !== undefined) entries[to].focus();
  else if (event.key === "Escape" || event.key === "Tab") leave();
  else return;
  event.preventDefault();
}

/** Copies a name, by which programs and the command line know a node. */
async function copy(name: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(name);
    say(`copied: ${name}`);
  } catch {
    say(`${name} is not copied: browsers let pages copy that come from this machine or by TLS`, "warning");
  }
}
