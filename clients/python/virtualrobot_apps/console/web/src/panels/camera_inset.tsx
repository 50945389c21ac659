// The live picture of a camera of the scene, in the corner of the view.
import { useEffect, useRef } from "preact/hooks";
import { blind, picture, watched } from "../kernel/camera_picture";
import { selected } from "../kernel/world";
import { Icon } from "../parts/icons";

export function CameraInset() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const now = picture.value;
  useEffect(() => {
    if (now) canvas.current?.getContext("2d")?.putImageData(now.pixels, 0, 0);
  }, [now]);
  if (!watched.value) return null;
  return (
    <figure class="float inset" aria-label={`Picture of ${watched.value}`}>
      <figcaption>
        <Icon name="camera" size={13} color="var(--sensor)" />
        <button type="button" class="link grow" onClick={() => (selected.value = watched.value)}>{watched.value}</button>
        {now && <span class="mono muted" title="Simulation time of the picture">{now.seconds.toFixed(2)} s</span>}
        <button type="button" class="tool small" title={`Show the picture of ${watched.value} no more`} onClick={() => (watched.value = "")}><Icon name="x" size={13} /></button>
      </figcaption>
      {blind.value && <p class="hint warned" role="alert"><Icon name="triangle-alert" size={13} />{blind.value}</p>}
      {!now && !blind.value && <p class="hint">Waiting for a picture; where time stands still there is none.</p>}
      {now && <canvas ref={canvas} width={now.pixels.width} height={now.pixels.height} role="img" aria-label={`What ${watched.value} sees`} />}
    </figure>
  );
}
