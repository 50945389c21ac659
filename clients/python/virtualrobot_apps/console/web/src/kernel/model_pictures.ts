// Pictures of the models of the catalogue, which the kernel takes: asked for one after the other, as people come to see them.
import { signal } from "@preact/signals";
import { views } from "./services";

/** Addresses of pictures by the names of their models; "" for what has none. */
export const pictures = signal<ReadonlyMap<string, string>>(new Map());

/** Names of models whose pictures are wanted, the newest last. */
const wanted = new Set<string>();
let asking = false;

export function want(name: string): void {
  if (pictures.peek().has(name)) return;
  wanted.add(name);
  if (!asking) void ask();
}

/** Takes back that a picture is wanted: who scrolls on waits for what is seen now. */
export function pass(name: string): void {
  wanted.delete(name);
}

/** Asks anew for what had no picture: another kernel may have it. */
export function forgetMissing(): void {
  pictures.value = new Map([...pictures.peek()].filter(([, address]) => address));
}

async function ask(): Promise<void> {
  asking = true;
  for (let name = [...wanted].at(-1); name !== undefined; name = [...wanted].at(-1)) {
    wanted.delete(name);
    pictures.value = new Map(pictures.peek()).set(name, await addressOf(name));
  }
  asking = false;
}

async function addressOf(name: string): Promise<string> {
  try {
    const { image } = await views.captureModel({ name });
    return URL.createObjectURL(new Blob([image.slice()], { type: "image/png" }));
  } catch {
    return "";
  }
}
