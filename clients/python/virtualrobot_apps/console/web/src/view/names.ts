// Names of nodes over the view, where their origins are, while somebody wants them.
import { signal } from "@preact/signals";
import { Vector3, type Matrix4, type PerspectiveCamera } from "three";
import type { Item, Kind } from "../kernel/world";

export const namesShown = signal(false);

/** What goes with something that has a name itself. */
const UNNAMED = new Set<Kind>(["world", "link", "adapter", "annotation", "viewpoint"]);

export class Names {
  readonly element = document.createElement("div");
  #labels = new Map<string, HTMLElement>();

  constructor() {
    this.element.className = "names";
    // The tree tells them to those who don't see the picture.
    this.element.ariaHidden = "true";
  }

  rebuild(items: Iterable<Item>): void {
    this.#labels = new Map([...items].filter(({ kind }) => !UNNAMED.has(kind)).map(({ name, kind }) => {
      const label = document.createElement("span");
      label.textContent = name;
      label.dataset.kind = kind;
      return [name, label];
    }));
    this.element.replaceChildren(...this.#labels.values());
  }

  place(places: ReadonlyMap<string, Matrix4>, shown: (name: string) => boolean, camera: PerspectiveCamera): void {
    const point = new Vector3();
    for (const [name, label] of this.#labels) {
      const pose = places.get(name);
      if (pose) point.setFromMatrixPosition(pose).project(camera);
      label.hidden = !pose || !shown(name) || Math.abs(point.z) > 1;
      label.style.left = `${50 * (point.x + 1)}%`;
      label.style.top = `${50 * (1 - point.y)}%`;
    }
  }
}
