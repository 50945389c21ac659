// The middle: the 3D view with its tools, and what the chosen robot does.
import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { filming } from "../kernel/films";
import { goal } from "../kernel/goal";
import { isolated } from "../kernel/isolation";
import { download, placing } from "../kernel/loader";
import { otherMover } from "../kernel/own_motions";
import { isOutdated } from "../kernel/served_page";
import { opened, shownLeft, toggle } from "../kernel/shown";
import { isTraced, trace, untrace } from "../kernel/traces";
import { chosen, connection, items, states, trouble } from "../kernel/world";
import { Icon } from "../parts/icons";
import { fixed, positionOf } from "../parts/numbers";
import { inToolAxes, tool, type Tool } from "../view/gizmo";
import { loading } from "../view/meshes";
import { draggedNode, snaps } from "../view/node_handle";
import { namesShown } from "../view/names";
import { Viewport } from "../view/viewport";
import { CameraInset } from "./camera_inset";
import { Devices } from "./devices";
import { Films } from "./films";
import { Legends } from "./legends";
import { Loading } from "./loading";
import { Measuring } from "./measuring";
import { Placing } from "./placing";
import { Question } from "./question";
import { InRoom, RoomTools } from "./room";
import { Speeds } from "./speeds";
import { Stopped } from "./stopped";

export const viewport: { current?: Viewport } = {};

const grid = signal(true);

export function View() {
  const host = useRef<HTMLDivElement>(null);
  // Before the effects of what is over it.
  useLayoutEffect(() => {
    viewport.current = new Viewport(host.current!);
  }, []);
  return (
    <main class="view" aria-label="Cell">
      <div ref={host} class="canvas" />
      <Handles />
      <Looks />
      <Robot />
      <CameraInset />
      <Legends />
      <Cover />
      <Empty />
      <Moved />
      <Alone />
      <InRoom />
      <Placing />
      <Speeds />
      <Films />
      <Devices />
      <Measuring />
      <Loading />
      <Question />
      <Outdated />
      <Stopped />
    </main>
  );
}

function Handles() {
  const one = (name: Tool, icon: string, title: string) => (
    <button type="button" class="tool" aria-pressed={tool.value === name} title={title} onClick={() => (tool.value = name)}>
      <Icon name={icon} size={17} />
    </button>
  );
  return (
    <div class="float top-left" role="toolbar" aria-label="Pointer">
      {one("select", "mouse-pointer-2", "Select (Q)")}
      {one("translate", "move-3d", "Drag the robot's tool (W)")}
      {one("rotate", "rotate-3d", "Turn the robot's tool (E)")}
      {one("move", "move", "Move the selected node (M)")}
      {one("turn", "rotate-cw", "Turn the selected node (T)")}
      {one("size", "scaling", "Draw faces of the selected node out or in (S)")}
      <span class="line" />
      <button type="button" class="tool" aria-pressed={snaps.value} title="Nodes that are moved snap: to 10 mm, and to faces beside them; turned, to 5°; sizes to 10 mm" onClick={() => (snaps.value = !snaps.value)}>
        <Icon name="magnet" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={inToolAxes.value} title="Drag along the own axes of the tool, or of the node" onClick={() => (inToolAxes.value = !inToolAxes.value)}>
        <Icon name="axis-3d" size={17} />
      </button>
    </div>
  );
}

function Looks() {
  return (
    <div class="float top-right" role="toolbar" aria-label="View">
      <button type="button" class="tool" title="Look at everything (F without selection)" onClick={() => viewport.current?.frame()}>
        <Icon name="maximize" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={grid.value} title="Grid: 0.25 m and 1 m" onClick={() => (grid.value = viewport.current?.toggleGrid() ?? false)}>
        <Icon name="grid-3x3" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={namesShown.value} title="Names of nodes (N)" onClick={() => (namesShown.value = !namesShown.peek())}>
        <Icon name="tag" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={opened.value === "measuring"} title="Measure: lengths, distances and angles, mm and ° (D)" onClick={() => toggle("measuring")}>
        <Icon name="ruler" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={isTraced(chosen.value)} title="Trace the robot's tool" onClick={() => (isTraced(chosen.value) ? untrace(chosen.value) : trace(chosen.value))}>
        <Icon name="route" size={17} />
      </button>
      <button type="button" class="tool" aria-pressed={opened.value === "films"} title="Films" onClick={() => toggle("films")}>
        <Icon name="video" size={17} color={filming() ? "var(--bad)" : undefined} />
      </button>
      <button type="button" class="tool" title="Save a picture" onClick={() => void save()}>
        <Icon name="camera" size={17} />
      </button>
      <RoomTools />
    </div>
  );
}

function Robot() {
  const state = states.value.get(chosen.value);
  if (!state) return null;
  const moves = state.motionIds.length > 0;
  return (
    <div class="float bottom-left facts" aria-label="Chosen robot">
      <Fact name="Robot"><span class="who">{chosen.value}{state.tool && ` · ${state.tool}`}</span></Fact>
      {positionOf(state.worldTTcp).map((value, place) => (
        <Fact key={place} name={`${"XYZ"[place]} (mm)`}><span class="mono coordinate">{fixed(1000 * value, 1)}</span></Fact>
      ))}
      <Fact name="Motion"><span id="motion" class={moves ? "good" : "muted"}>{moves ? "running" : "at rest"}</span></Fact>
      {otherMover.value && <Fact name="Moved by"><span class="warned" id="mover">{otherMover.value}</span></Fact>}
      {goal.reach.value !== "unknown" && (
        <Fact name="Goal">
          <span class={goal.reach.value === "reached" ? "accent" : "bad"}>{goal.reach.value === "reached" ? "reachable" : "out of reach"}</span>
        </Fact>
      )}
    </div>
  );
}

function Fact({ name, children }: { name: string; children: ComponentChildren }) {
  return <div class="fact"><b>{name}</b>{children}</div>;
}

/** Says how a cell begins, where there is none yet. */
function Empty() {
  if (connection.value !== "connected" || items.value.size !== 1 || placing.value) return null;
  const show = () => {
    shownLeft.value = "library";
    document.querySelector(".left")?.scrollIntoView({ block: "nearest" });
  };
  return (
    <div class="empty">
      <h2>Nothing is here yet</h2>
      <p class="muted">Take a robot from the library, open a scene, or drop files of models here.</p>
      <button type="button" class="button primary" onClick={show}><Icon name="library" size={15} />Show the library</button>
    </div>
  );
}

/** Says where a node would be that is dragged, and at whose face, or how large. */
function Moved() {
  const dragged = draggedNode.value;
  if (!dragged) return null;
  const { name, position, turnDegrees, size, beside } = dragged;
  const words = size
    ? `${size.name} ${fixed(1000 * size.meters, 1)} mm`
    : turnDegrees === undefined ? `${position.toArray().map((value) => fixed(1000 * value, 1)).join(" ")} mm` : `turned by ${fixed(turnDegrees, 1)}°`;
  return (
    <div class="float moved" role="status">
      <Icon name={size ? "scaling" : "move-3d"} size={16} color="var(--part)" />
      <b class="cut">{name}</b>
      <span class="mono">{words}</span>
      {beside.length > 0 && <span class="accent cut">at {beside.join(", ")}</span>}
    </div>
  );
}

/** Says that the console has been updated. */
function Outdated() {
  if (!isOutdated.value) return null;
  return (
    <div class="float outdated" role="status">
      <Icon name="rotate-cw" size={16} color="var(--warning)" />
      <span class="cut">The console serves another version of this page now</span>
      <button type="button" class="button small" title="Taught programs that aren't saved are lost by it" onClick={() => location.reload()}>Reload</button>
      <button type="button" class="tool small" title="Stay with this version" onClick={() => (isOutdated.value = false)}><Icon name="x" size={14} /></button>
    </div>
  );
}

/** Says that the rest of the cell is not shown. */
function Alone() {
  const name = isolated.value;
  if (!name || placing.value) return null;
  return (
    <div class="float alone" role="status">
      <Icon name="scan-eye" size={16} color="var(--accent)" />
      <span class="cut" title="On this page; others and cameras show the whole cell">Only <b>{name}</b> is shown</span>
      <button type="button" class="button small" title="Show the whole cell again (I)" onClick={() => (isolated.value = "")}>Show all</button>
    </div>
  );
}

/** Says why nothing is shown, or not what is. */
function Cover() {
  if (connection.value === "refused") {
    return (
      <div class="cover solid" role="alert">
        <h2>This page may not come in</h2>
        <p title={trouble.value}>It has no session here: a link lets one browser in, for as long as console and kernel run.</p>
        <p class="muted">Open the link that was printed last where the kernel was started, or that <code>virtualrobot console</code> prints.</p>
      </div>
    );
  }
  const words = connection.value === "lost" ? `${trouble.value}; trying again` : connection.value === "connecting" ? "connecting" : loading.value;
  return words ? <div class="cover"><span class="float said" role="status">{words} …</span></div> : null;
}

async function save(): Promise<void> {
  const blob = await viewport.current?.picture();
  if (!blob) return;
  download(blob, "cell.png");
}
