// What phones without WebXR have: the cell over the camera's picture, and as a still.
import { fieldDegrees, overlaid, overlay, said, sheet } from "../xr/phone";
import { Icon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import { NumberField } from "../parts/number_field";
import { viewport } from "./view";

/** An image that Apple's browsers want in a link to a still. */
const DOT = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' width='1' height='1'/%3E";

export function Phone() {
  return (
    <>
      <div class="row">
        <button type="button" class="button grow" title="The cell over the picture of this device's camera, where a printed marker is" onClick={() => void press()}>
          <Icon name="camera" size={14} />{overlaid.value ? "Leave the camera" : "Over the camera"}
        </button>
        <a class="button" rel="ar" href="/cell.usdz" download="cell.usdz" title="The cell as it stands, for phones and headsets of Apple (USDZ)"><img alt="" src={DOT} style={{ position: "absolute" }} />Still</a>
      </div>
      {said.value && <p class="hint" role="status" id="overlaid">{said.value}.</p>}
      {overlaid.value && (
        <div class="row">
          <NodeField label="Node where the printed marker is" name="marker" value={sheet.value} choose={(name) => (sheet.value = name)} />
          <NumberField label="Horizontal field of view of the camera, 10 to 150" value={fieldDegrees.value} unit="°" decimals={1} write={(to) => (fieldDegrees.value = Math.min(150, Math.max(10, to)))} />
        </div>
      )}
    </>
  );
}

function press(): Promise<void> | void {
  if (overlaid.peek()) overlaid.peek()!.end();
  else if (viewport.current) return overlay(viewport.current);
}
