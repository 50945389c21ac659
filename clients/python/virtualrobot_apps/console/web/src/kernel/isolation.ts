// Which node this page shows alone, with all that hangs below it. Other pages, cameras and the kernel's view show the cell as it is.
import { signal } from "@preact/signals";
import { hearers, items } from "./world";

/** Name of the node that is shown alone; "" for the whole cell. */
export const isolated = signal("");

/** Shows a node alone, or the whole cell again when it is alone already. */
export function isolate(name: string): void {
  isolated.value = name === isolated.peek() || items.peek().get(name)?.kind === "world" ? "" : name;
}

hearers.structure.add((renamed) => {
  const name = renamed.get(isolated.peek()) ?? isolated.peek();
  isolated.value = items.peek().has(name) ? name : "";
});
