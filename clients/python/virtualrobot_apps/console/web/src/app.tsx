// The page's frame: what is on top, left, in the middle, right, below.
import { undo, redo } from "./kernel/orders";
import { goal } from "./kernel/goal";
import { helps } from "./kernel/help";
import { isolate } from "./kernel/isolation";
import { keyboard } from "./kernel/keyboard";
import { opened, shownBelow, shownLeft, shownRight, toggle } from "./kernel/shown";
import { selected } from "./kernel/world";
import { Chosen, Tabs, type Tab } from "./parts/tabs";
import { WhileConnected } from "./parts/while_connected";
import { WrongNumber } from "./parts/wrong_number";
import { Bottom, toolsBelow } from "./panels/bottom";
import { Finder, openFinder, type Group } from "./panels/finder";
import { Help } from "./panels/help";
import { Library } from "./panels/library";
import { NodeMenu } from "./panels/node_menu";
import { Parts } from "./panels/parts";
import { Pendant } from "./panels/pendant";
import { Properties } from "./panels/properties";
import { Status } from "./panels/status";
import { Top } from "./panels/top";
import { Tree } from "./panels/tree";
import { View, viewport } from "./panels/view";
import { turnTo, Views } from "./panels/views";
import { stop } from "./kernel/stop";
import { leave } from "./view/aiming";
import { namesShown } from "./view/names";
import { tool } from "./view/gizmo";

const LEFT: readonly Tab[] = [
  { id: "scene", icon: "waypoints", name: "Scene", panel: Tree },
  { id: "library", icon: "library", name: "Library", panel: Library },
];
const RIGHT: readonly Tab[] = [
  { id: "pendant", icon: "gamepad-2", name: "Pendant", panel: Pendant },
  { id: "parts", icon: "package", name: "Parts", panel: Parts },
  { id: "views", icon: "camera", name: "Views", panel: Views },
  { id: "properties", icon: "box", name: "Properties", panel: Properties },
];
/** All panels, of which one of a group is shown. */
const groups = (): Group[] => [{ chosen: shownLeft, tabs: LEFT }, { chosen: shownRight, tabs: RIGHT }, { chosen: shownBelow, tabs: toolsBelow() }];

export function App() {
  return (
    <div class="shell">
      <Top />
      <aside class="left" aria-label="Scene">
        <Tabs label="Left" chosen={shownLeft.value} choose={(id) => (shownLeft.value = id)} tabs={LEFT} />
        <WhileConnected><Chosen tabs={LEFT} chosen={shownLeft.value} /></WhileConnected>
      </aside>
      <View />
      <aside class="right" aria-label="Robot and properties">
        <Tabs label="Right" chosen={shownRight.value} choose={(id) => (shownRight.value = id)} tabs={RIGHT} />
        <WhileConnected><Chosen tabs={RIGHT} chosen={shownRight.value} /></WhileConnected>
      </aside>
      <Bottom />
      <Status />
      <Finder />
      <NodeMenu />
      <WrongNumber />
      <Help left={shownLeft.value} />
    </div>
  );
}

/** Returns whether a key is meant for a field that is typed into; no number has a space in it. */
function isTyped(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement;
  if (target instanceof HTMLTextAreaElement || target.dataset.typed !== undefined) return true;
  if (!(target instanceof HTMLInputElement)) return target.tagName === "SELECT" && event.code !== "Space";
  return target.type !== "range" && !target.readOnly && !(event.code === "Space" && target.inputMode === "decimal");
}

/** Returns whether a key is meant for what takes letters itself, such as driving by keys. */
function isOwnKey(event: KeyboardEvent): boolean {
  return (event.target as HTMLElement).closest?.("[data-keys]") != null;
}

const KEYS: Record<string, () => void> = {
  q: () => (tool.value = "select"),
  w: () => (tool.value = "translate"),
  e: () => (tool.value = "rotate"),
  m: () => (tool.value = "move"),
  t: () => (tool.value = "turn"),
  s: () => (tool.value = "size"),
  f: () => viewport.current?.frame(selected.value),
  i: () => isolate(selected.value),
  d: () => toggle("measuring"),
  n: () => (namesShown.value = !namesShown.peek()),
  Escape: () => {
    viewport.current?.nodeHandle.leave();
    viewport.current?.sizeHandle.leave();
    goal.clear();
    leave();
    if (opened.value === "measuring") opened.value = "";
  },
};

addEventListener(
  "keydown",
  (event) => {
    if (event.key.toLowerCase() === "k" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      openFinder(groups());
      return;
    }
    if (event.key === "F1") {
      event.preventDefault();
      helps.value = !helps.peek();
      return;
    }
    if (isTyped(event)) return;
    if (event.code === "Space") {
      // Whatever has the focus: a button that would be pressed by it is not.
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) void stop();
    } else if (event.key.toLowerCase() === "z" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      void (event.shiftKey ? redo() : undo());
    } else if (!event.ctrlKey && !event.metaKey && !event.altKey && !isOwnKey(event) && !(keyboard.isUsed && event.shiftKey)) {
      KEYS[event.key]?.();
      if (/^[1-7]$/.test(event.key)) turnTo(Number(event.key));
    }
  },
  { capture: true },
);
addEventListener("keyup", (event) => event.code === "Space" && !isTyped(event) && event.preventDefault(), { capture: true });
