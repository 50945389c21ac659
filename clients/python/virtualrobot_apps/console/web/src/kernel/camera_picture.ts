// The picture of a camera of the scene, as it takes it: it is read while somebody looks.
import { effect, signal } from "@preact/signals";
import { ImageKind } from "../generated/virtualrobot/v1/sensing_pb";
import type { Image, SensorReading } from "../generated/virtualrobot/v1/sensor_pb";
import { ofArray } from "./arrays";
import { sensors } from "./services";
import { wordsOf } from "./words";
import { connection, hearers } from "./world";

const MOST_HERTZ = 5;

/** The camera whose picture is shown; "" for none. */
export const watched = signal("");

/** Its newest picture, and the simulation time in which it was taken. */
export const picture = signal<{ pixels: ImageData; seconds: number } | undefined>(undefined);

/** Why there is none, in words; "" where there is one, or none yet. */
export const blind = signal("");

effect(() => {
  const name = watched.value;
  picture.value = undefined;
  blind.value = "";
  if (!name || connection.value !== "connected") return;
  const over = new AbortController();
  void follow(name, over.signal);
  return () => over.abort();
});

hearers.structure.add((renamed) => (watched.value = renamed.get(watched.peek()) ?? watched.peek()));

async function follow(name: string, end: AbortSignal): Promise<void> {
  try {
    for await (const { readings } of sensors.watchReadings({ sensors: [name], maxRateHertz: MOST_HERTZ, run: true }, { signal: end })) {
      if (end.aborted) return;
      for (const reading of readings) take(reading);
    }
  } catch (error) {
    if (!end.aborted) blind.value = wordsOf(error);
  }
}

function take({ reading, fault, stamp }: SensorReading): void {
  if (reading.case !== "camera") {
    if (fault) blind.value = fault;
    return;
  }
  const { images, width, height } = reading.value;
  const image = images.find(({ kind, right }) => kind === ImageKind.COLOR && !right) ?? images.find(({ kind, right }) => kind === ImageKind.DEPTH && !right);
  const pixels = image && drawn(image, width, height);
  blind.value = pixels ? "" : "this camera takes neither colour nor depth";
  if (pixels) picture.value = { pixels, seconds: stamp?.simulationTimeSeconds ?? 0 };
}

/** Returns colours as they are, and depths in grey: the nearest is white, the farthest that is anything is dark. */
function drawn({ kind, pixels }: Image, width: number, height: number): ImageData | undefined {
  if (!pixels || pixels.data.length === 0) return undefined;
  const data = new ImageData(width, height);
  data.data.fill(255);
  if (kind === ImageKind.COLOR) {
    for (let place = 0; place < width * height; place++) data.data.set(pixels.data.subarray(3 * place, 3 * place + 3), 4 * place);
    return data;
  }
  const depths = ofArray(pixels);
  let least = Infinity, most = 0;
  for (const depth of depths) {
    if (!Number.isFinite(depth)) continue;
    least = Math.min(least, depth);
    most = Math.max(most, depth);
  }
  depths.forEach((depth, place) => {
    const light = Number.isFinite(depth) ? 255 - (215 * (depth - least)) / Math.max(most - least, 1e-9) : 0;
    data.data.fill(light, 4 * place, 4 * place + 3);
  });
  return data;
}
