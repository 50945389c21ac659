// Meshes as the kernel reads them, by content: each is asked for once, as glTF, and drawn wherever its content is.
import { BufferGeometry, Float32BufferAttribute, Matrix4, Mesh, type MeshStandardMaterial, type Object3D } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { signal } from "@preact/signals";
import type { Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { say } from "../kernel/messages";
import { assets, scenes } from "../kernel/services";
import { wordsOf } from "../kernel/words";
import { below, items } from "../kernel/world";
import { isSmall } from "../xr/support";
import { contentOf, seen, type Piece } from "./figures";
import { matrixOf } from "./poses";

type Part = Omit<Piece, "color">;

const MOST_ASKED = 3;
/** How far surfaces may be off on headsets and phones, m. */
const TOLERANCE = 0.001;

/** What is being loaded, in words; "" when nothing is. */
export const loading = signal("");

export class Meshes {
  #parts = new Map<string, Part[]>();
  /** How often each content was asked for: a node that is renamed meanwhile isn't found in the answer. */
  #asked = new Map<string, number>();
  #running = false;

  /** `changed` is called when there are more of them. */
  constructor(private readonly changed: () => void) {}

  /** Returns the pieces of a figure; undefined when its mesh is not here yet. */
  piecesOf(figure: Figure): Piece[] | undefined {
    const parts = this.#parts.get(contentOf(figure));
    const local = matrixOf(figure.nodeTFigure);
    return parts?.map((part) => ({ ...part, local: local.clone().multiply(part.local) }));
  }

  /** Asks for the contents that nodes have, each once; the first time for those of the whole world together. */
  async want(missing: ReadonlyMap<string, readonly string[]>): Promise<void> {
    if (this.#running) return;
    const fresh = [...missing].filter(([, contents]) => contents.some((content) => (this.#asked.get(content) ?? 0) < MOST_ASKED));
    if (fresh.length === 0) return;
    this.#running = true;
    loading.value = "loading the cell";
    const roots = this.#asked.size === 0 ? ["world"] : fresh.map(([name]) => name);
    for (const [, contents] of fresh) for (const content of contents) this.#asked.set(content, (this.#asked.get(content) ?? 0) + 1);
    for (const name of roots) {
      try {
        await this.#load(name);
      } catch (error) {
        say(`meshes of ${name}: ${wordsOf(error)}`, "error");
        for (const [, contents] of fresh) for (const content of contents) this.#asked.set(content, MOST_ASKED);
      }
    }
    loading.value = "";
    this.#running = false;
    this.changed();
  }

  async #load(root: string): Promise<void> {
    const toleranceMeters = (await isSmall()) ? TOLERANCE : 0;
    // What is listed before the answer has the numbers that the answer's names have.
    const listed = below(root).flatMap((name) => {
      const item = items.peek().get(name);
      return item ? seen(item).map((figure, place) => ({ figure, name: `${name} figure ${place + 1}` })) : [];
    });
    const { files } = await scenes.exportModel({ node: root === "world" ? "" : root, format: ".glb", toleranceMeters });
    const chunks: Uint8Array<ArrayBuffer>[] = [];
    for await (const { chunk } of assets.downloadAsset({ sha256: files[0].sha256 })) chunks.push(chunk as Uint8Array<ArrayBuffer>);
    const data = await new Blob(chunks).arrayBuffer();
    const { scene } = await new GLTFLoader().parseAsync(data, "");
    scene.updateMatrixWorld(true);
    const found = new Map<string, Object3D>();
    scene.traverse((object) => found.set((object.userData.name as string | undefined) ?? object.name, object));
    for (const { figure, name } of listed) {
      const content = contentOf(figure), object = found.get(name);
      if (content && object && !this.#parts.has(content)) this.#parts.set(content, partsOf(object));
    }
  }
}

function partsOf(object: Object3D): Part[] {
  const inverse = new Matrix4().copy(object.matrixWorld).invert();
  const parts: Part[] = [];
  object.traverse((child) => {
    if (!(child instanceof Mesh)) return;
    const material = child.material as MeshStandardMaterial;
    const local = inverse.clone().multiply(child.matrixWorld);
    const { geometry } = child as Mesh;
    const placed = isFloats(geometry) ? { geometry, local } : { geometry: floats(geometry).applyMatrix4(local), local: new Matrix4() };
    parts.push({ ...placed, material, opaque: !material.transparent });
  });
  return parts;
}

function isFloats(geometry: BufferGeometry): boolean {
  return geometry.getAttribute("position").array instanceof Float32Array;
}

/** Returns a geometry whose places and normals are floats in place of integers: those of one drawing have to be of one type. */
function floats(geometry: BufferGeometry): BufferGeometry {
  const made = new BufferGeometry().setIndex(geometry.index);
  for (const [name, given] of Object.entries(geometry.attributes)) made.setAttribute(name, given);
  for (const name of ["position", "normal"]) {
    const given = geometry.getAttribute(name), numbers = new Float32Array(3 * given.count);
    for (let at = 0; at < numbers.length; at++) numbers[at] = given.getComponent(Math.floor(at / 3), at % 3);
    made.setAttribute(name, new Float32BufferAttribute(numbers, 3));
  }
  return made;
}
