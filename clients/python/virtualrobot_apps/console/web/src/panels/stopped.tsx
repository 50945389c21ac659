// Who has stopped the cell, when and why, and the button that releases it.
import { release, stopping, stoppedBy, stopReason } from "../kernel/stop";
import { cell } from "../kernel/world";
import { Icon } from "../parts/icons";

export function Stopped() {
  const stop = cell.value;
  if (!stop?.stopped) return null;
  const rests = stopping.value === "stopped";
  const time = stop.stopTime ? new Date(1000 * Number(stop.stopTime.seconds)).toTimeString().slice(0, 8) : "";
  return (
    <div class="float stopped-by" role="alert" id="stopped">
      <Icon name="stop" size={18} width={2.4} color="var(--danger)" />
      <span class="words" title={`${stop.stoppedBy}: ${stop.reason}`}>
        <b>{rests ? "Stopped" : "Braking"}</b> by {stoppedBy.value} at {time}{stopReason.value && `: ${stopReason.value}`}{rests && "; press Release to go on"}
      </span>
      <button type="button" class="button" id="release" disabled={!rests} title="Robots may move again; nothing moves by this" onClick={() => void release()}>
        Release
      </button>
    </div>
  );
}
