// The tree of nodes: found, selected, renamed, hidden, and hung elsewhere by dragging.
import { computed, signal } from "@preact/signals";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { attach, remove, rename, setHidden } from "../kernel/orders";
import { nodeMenu } from "../kernel/shown";
import { children, chosen, items, leases, selected, type Item } from "../kernel/world";
import { Icon, KindIcon } from "../parts/icons";
import { Adding } from "./adding";
import { viewport } from "./view";

interface Row {
  item: Item;
  depth: number;
  inside: number;
}

const filter = signal("");
const renamed = signal("");
const dragged = signal("");
const aim = signal("");
/** Nodes that people have opened or closed; links of robots are closed to begin with. */
const opened = signal<ReadonlyMap<bigint, boolean>>(new Map());

const isOpen = (item: Item) => opened.value.get(item.uid) ?? item.kind !== "robot";

/** Renames a node in its row, as soon as that is there. */
export const beginRenaming = (name: string) => void (renamed.value = name);

const openMenu = ({ name }: Item, x: number, y: number) => void (nodeMenu.value = { name, part: "", x, y });

const rows = computed(() => {
  const found: Row[] = [];
  const words = filter.value.trim().toLowerCase();
  const walk = (item: Item, depth: number) => {
    const inside = children.value.get(item.name) ?? [];
    if (!words) found.push({ item, depth, inside: inside.length });
    else if (isAbout(item, words)) found.push({ item, depth: 0, inside: 0 });
    if (words || isOpen(item)) for (const child of inside) walk(child, depth + 1);
  };
  const world = items.value.get("world");
  if (world) walk(world, 0);
  return found;
});

/** Whether a node is called so, has such a tag, or is so described. */
function isAbout({ name, node: { tags, description } }: Item, words: string): boolean {
  return [name, ...tags, description].some((text) => text.toLowerCase().includes(words));
}

export function Tree() {
  return (
    <>
      <label class="search">
        <Icon name="search" size={14} />
        <input placeholder="Filter scene" aria-label="Filter scene" value={filter.value} onInput={(event) => (filter.value = event.currentTarget.value)} />
      </label>
      <div class="tree" role="tree" aria-label="Nodes" tabIndex={0} onKeyDown={walkByKeys}>
        {rows.value.map((row) => <NodeRow key={row.item.uid} {...row} />)}
        {rows.value.length === 0 && filter.value && <p class="hint">Nothing is called, tagged or described so.</p>}
      </div>
      <Adding />
    </>
  );
}

function NodeRow({ item, depth, inside }: Row) {
  const { name, kind, hidden, node } = item;
  const isSelected = selected.value === name;
  const row = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (isSelected) row.current?.scrollIntoView({ block: "nearest" });
  }, [isSelected]);
  const classes = ["node", hidden && "off", aim.value === name && dragged.value && "aim"].filter(Boolean).join(" ");
  return (
    <div ref={row} class={classes} role="treeitem" aria-selected={isSelected} aria-level={depth + 1} data-name={name}
      aria-expanded={inside > 0 ? isOpen(item) : undefined} style={{ paddingLeft: `${4 + 14 * depth}px` }} title={node.description ? `${name}: ${node.description}` : name}
      draggable={kind !== "link" && kind !== "world" && !node.locked && renamed.value !== name}
      onDragStart={(event) => {
        dragged.value = name;
        event.dataTransfer?.setData("text/plain", name);
      }}
      onDragOver={(event) => {
        event.preventDefault();
        aim.value = name;
      }}
      onDragEnd={() => (dragged.value = aim.value = "")}
      onDrop={(event) => {
        event.preventDefault();
        if (dragged.value && dragged.value !== name) void attach(dragged.value, name);
        dragged.value = aim.value = "";
      }}
      onContextMenu={(event) => {
        event.preventDefault();
        event.currentTarget.parentElement?.focus({ preventScroll: true });
        select(item);
        openMenu(item, event.clientX, event.clientY);
      }}
      onClick={() => select(item)} onDblClick={() => kind !== "world" && (renamed.value = name)}>
      <span class="twist" onClick={(event) => (event.stopPropagation(), toggle(item))}>
        {inside > 0 && <Icon name={isOpen(item) ? "chevron-down" : "chevron-right"} size={13} />}
      </span>
      <KindIcon kind={kind === "robot" && items.value.get(item.parent)?.kind === "link" ? "gripper" : kind} icon={node.icon} />
      {renamed.value === name ? <NameField item={item} /> : <span class="label">{shown(item)}</span>}
      {node.locked && <span title="Locked: it stays as it is"><Icon name="lock" size={12} color="var(--muted)" /></span>}
      {leases.value.some(({ robots }) => robots.includes(name)) && <Icon name="lock" size={12} color="var(--warning)" />}
      {kind !== "world" && (
        <span class="acts">
          <button type="button" title={`Look at ${name} (F)`} onClick={(event) => (event.stopPropagation(), viewport.current?.frame(name))}>
            <Icon name="crosshair" size={13} />
          </button>
          <button type="button" title={hidden ? `Show ${name}` : `Hide ${name}`} onClick={(event) => (event.stopPropagation(), void setHidden(name, !hidden))}>
            <Icon name={hidden ? "eye-off" : "eye"} size={13} />
          </button>
        </span>
      )}
    </div>
  );
}

function NameField({ item: { name } }: { item: Item }) {
  const field = useRef<HTMLInputElement>(null);
  // At once: who types on would else press keys that the page knows.
  useLayoutEffect(() => field.current?.select(), []);
  return (
    <input ref={field} aria-label={`New name of ${name}`} defaultValue={name} onBlur={() => (renamed.value = "")}
      onClick={(event) => event.stopPropagation()}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key !== "Enter" && event.key !== "Escape") return;
        const to = event.currentTarget.value.trim();
        if (event.key === "Enter" && to && to !== name) void rename(name, to);
        renamed.value = "";
      }} />
  );
}

/** Returns what a row is called: links without their robot's name. */
function shown({ kind, name, parent }: Item): string {
  const robot = kind === "link" && name.startsWith(`${parent.split(".")[0]}.`) ? parent.split(".")[0].length + 1 : 0;
  return name.slice(robot);
}

function select(item: Item): void {
  selected.value = item.name;
  if (item.kind === "robot") chosen.value = item.name;
}

function toggle(item: Item): void {
  opened.value = new Map(opened.value).set(item.uid, !isOpen(item));
}

function walkByKeys(event: KeyboardEvent): void {
  const place = rows.value.findIndex(({ item }) => item.name === selected.value);
  const row = rows.value[place];
  const to = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: rows.value.length - 1 }[event.key];
  const line = document.querySelector<HTMLElement>('.node[aria-selected="true"]')?.getBoundingClientRect();
  if (to !== undefined && rows.value[to]) select(rows.value[to].item);
  else if (event.key === "ArrowRight" && row && !isOpen(row.item)) toggle(row.item);
  else if (event.key === "ArrowLeft" && row && row.inside > 0 && isOpen(row.item)) toggle(row.item);
  else if (event.key === "F2" && row && row.item.kind !== "world") renamed.value = row.item.name;
  else if (event.key === "Delete" && row && row.item.kind !== "world" && row.item.kind !== "link") void remove(row.item.name);
  else if (row && line && (event.key === "ContextMenu" || (event.key === "F10" && event.shiftKey))) openMenu(row.item, line.left + 40, line.bottom);
  else return;
  event.preventDefault();
}
