// Whether the console serves another page by now, such as after an update: the name of a page's script changes with its content.
import { signal } from "@preact/signals";

export const isOutdated = signal(false);

const SCRIPT = 'script[type="module"][src]';

const scriptOf = (page: Document) => page.querySelector(SCRIPT)?.getAttribute("src");

/** Compares this page with the one that is served. */
export async function compare(): Promise<void> {
  try {
    const answer = await fetch("/", { cache: "no-store" });
    const served = scriptOf(new DOMParser().parseFromString(await answer.text(), "text/html"));
    isOutdated.value = answer.ok && served !== undefined && served !== scriptOf(document);
  } catch {
    // The watches tell when the console is gone.
  }
}
