// Traces: which nodes draw the way that they go, in what colour and how far back; kept in the world, or cleared.
import { clearTrace, gone, isTraced, keepTrace, setTrace, trace, traces, untrace, ways, type Trace } from "../kernel/traces";
import { chosen, items, selected } from "../kernel/world";
import { Icon, KindIcon } from "../parts/icons";
import { NumberField } from "../parts/number_field";
import { fixed } from "../parts/numbers";

export function Traces() {
  const node = selected.value && selected.value !== "world" ? selected.value : chosen.value;
  return (
    <>
      <div class="list" role="list" aria-label="Traces">
        {traces.value.length === 0 && <p class="hint">Nothing is traced. Select a robot, a tool, a part or a link, and trace it; of a robot it is the way of its tool centre point.</p>}
        {traces.value.map((one) => <Row key={one.node} one={one} />)}
      </div>
      <div class="under program-bar">
        <button type="button" class="button small" id="trace" disabled={!node || isTraced(node)} onClick={() => trace(node)}>
          <Icon name="route" size={13} />Trace {node || "…"}
        </button>
        <span class="grow" />
        <button type="button" class="button small" disabled={traces.value.length === 0} onClick={() => traces.value.forEach((one) => clearTrace(one.node))}>Clear all</button>
      </div>
    </>
  );
}

function Row({ one }: { one: Trace }) {
  void gone.value;
  const { node, color, seconds, live } = one;
  const meters = ways.get(node)?.meters ?? 0;
  return (
    <div class="entry" role="listitem" aria-label={`Trace of ${node}`}>
      <button type="button" role="switch" class="switch" aria-label={`Trace ${node} on`} aria-checked={live} title={live ? "It grows as the node moves" : "It stays as it is"} onClick={() => setTrace(node, { live: !live })} />
      <input type="color" class="color" aria-label={`Colour of the trace of ${node}`} value={color} onInput={(event) => setTrace(node, { color: event.currentTarget.value })} />
      <KindIcon kind={items.value.get(node)?.kind ?? "object"} size={14} />
      <button type="button" class="link grow" onClick={() => (selected.value = node)}>{node}</button>
      <span class="mono muted meters">{fixed(1000 * meters, 0)} mm</span>
      <NumberField label={`How far back the trace of ${node} goes; 0 is all`} name="last" value={seconds} unit="s" decimals={1} write={(to) => setTrace(node, { seconds: Math.max(0, to) })} />
      <button type="button" class="button small" title="Make it a node of the world, which everybody sees and scene files keep" disabled={meters === 0} onClick={() => void keepTrace(one)}><Icon name="save" size={13} />Keep</button>
      <button type="button" class="tool small" title={`Clear the trace of ${node}`} onClick={() => clearTrace(node)}><Icon name="eraser" size={14} /></button>
      <button type="button" class="tool small" title={`Trace ${node} no more`} onClick={() => untrace(node)}><Icon name="x" size={14} /></button>
    </div>
  );
}
