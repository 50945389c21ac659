// Measuring: two features that are clicked, or origins of nodes that are named, and what is between them while things move.
import { computed, effect, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Vector3 } from "three";
import { opened } from "../kernel/shown";
import { items, moves } from "../kernel/world";
import { Icon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import { fixed } from "../parts/numbers";
import { leave, take as takeClicks } from "../view/aiming";
import { featureAim, featureAt, moved, type Found } from "../view/finding";
import { measure, wordsOf, type Measured } from "../view/measuring";
import { showSpans } from "../view/spans";
import { viewport } from "./view";

const COLOR = "#ffd65c";
const NAMES = ["From", "To"];

const ends = signal<readonly (Found | undefined)[]>([undefined, undefined]);

const isThere = (end: Found | undefined) => end !== undefined && items.value.has(end.node);

/** Both features where they are now, as long as their nodes are there. */
const now = computed(() => {
  void moves.value;
  if (opened.value !== "measuring") return undefined;
  const found = ends.value.filter(isThere).flatMap((end) => {
    const place = viewport.current?.solids.places.get(end!.node);
    return place ? [moved(end!.feature, place)] : [];
  });
  return found.length === 2 ? found : undefined;
});

const result = computed<Measured | undefined>(() => now.value && measure(now.value[0], now.value[1]));

/** Takes a feature as the end that is open, or begins anew with it; whoever wants clicks for something else closes the panel. */
const aim = featureAim(featureAt, (found) => {
  if (!found) return;
  const [first, second] = ends.peek();
  ends.value = first && !second ? [first, found] : [found, undefined];
}, () => opened.peek() === "measuring" && (opened.value = ""));

export function Measuring() {
  return opened.value === "measuring" ? <Panel /> : null;
}

function Panel() {
  useEffect(() => {
    takeClicks(aim);
    const off = effect(() => showSpans("measured", now.value ? [{ from: now.value[0].point, to: now.value[1].point, color: COLOR }] : []));
    return () => {
      leave(aim);
      off();
      showSpans("measured", []);
    };
  }, []);
  const open = ends.value[0] && !ends.value[1] ? 1 : 0;
  return (
    <section class="float over" aria-label="Measure" onKeyDown={(event) => event.key === "Escape" && (opened.value = "")}>
      <div class="row"><b class="grow">Measure</b>
        <button type="button" class="tool small" title="Begin anew" disabled={!ends.value.some(Boolean)} onClick={() => (ends.value = [undefined, undefined])}><Icon name="eraser" size={14} /></button>
        <button type="button" class="tool small" title="Close" onClick={() => (opened.value = "")}><Icon name="x" size={14} /></button>
      </div>
      {ends.value.map((end, place) => <End key={NAMES[place]} end={isThere(end) ? end : undefined} place={place} />)}
      {result.value ? <Result {...result.value} /> : (
        <p class="hint" role="status">{open === 0 ? "Click" : "And the other one:"} a corner, an edge, a hole or a face in the view, or write a node's name for its origin.</p>
      )}
    </section>
  );
}

function End({ end, place }: { end: Found | undefined; place: number }) {
  const name = (node: string) => {
    const origin: Found | undefined = items.peek().has(node) ? { node, feature: { kind: "corner", point: new Vector3() } } : undefined;
    ends.value = ends.peek().with(place, origin);
  };
  return (
    <div class="row">
      <NodeField label={`${NAMES[place]}: a node's origin`} name={NAMES[place]} value={end && isOrigin(end) ? end.node : ""} placeholder="a node" choose={name} />
      <span class="muted grow">{end && (isOrigin(end) ? "its origin" : `${wordsOf(end.feature)} of ${end.node}`)}</span>
    </div>
  );
}

function isOrigin({ feature }: Found): boolean {
  return feature.kind === "corner" && feature.point.lengthSq() === 0;
}

function Result({ between, square, angle }: Measured) {
  const rows: [string, string][] = [
    ["Distance", millimeters(between.length())],
    ...between.toArray().map((meters, axis): [string, string] => [`${"XYZ"[axis]} in the world`, millimeters(meters)]),
    ...(square ? [[square.name, millimeters(square.meters)] as [string, string]] : []),
    ...(angle === undefined ? [] : [["Angle", `${fixed(angle, 2)}°`] as [string, string]]),
  ];
  return (
    <dl class="measured" aria-live="polite" aria-label="Measured">
      {rows.map(([name, text]) => <div key={name} class="row"><dt class="muted grow">{name}</dt><dd class="mono words">{text}</dd></div>)}
    </dl>
  );
}

function millimeters(meters: number): string {
  return `${fixed(1000 * meters, 2)} mm`;
}
