// Coats in the view: triangles where all corners have a value, each corner in the colour of its own.
import { effect } from "@preact/signals";
import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Mesh, MeshStandardMaterial } from "three";
import { ofArray } from "../kernel/arrays";
import { coats, type Worn } from "../kernel/coats";
import { names } from "../kernel/world";
import type { Solids } from "./solids";
import type { Viewport } from "./viewport";

const COLORS = 256;
const ROUGHNESS = 0.55;

/** Draws all coats into a view from now on. */
export function drawCoats(view: Viewport): void {
  const drawn = new Map<string, Layer>();
  effect(() => {
    for (const [name, layer] of drawn) {
      if (coats.value.get(name)?.coat === layer.worn.coat) continue;
      view.overlay.remove(layer);
      layer.geometry.dispose();
      drawn.delete(name);
    }
    for (const [name, worn] of coats.value) {
      let layer = drawn.get(name);
      if (layer?.worn === worn) continue;
      if (!layer) {
        layer = new Layer(worn, view.solids);
        drawn.set(name, layer);
        view.overlay.add(layer);
      }
      layer.paint(worn);
    }
    view.invalidate();
  });
}

/** A coat that goes along with its node. */
class Layer extends Mesh<BufferGeometry, MeshStandardMaterial> {
  #faces: Uint32Array;
  #palette: Float32Array;
  #shown: BufferAttribute;
  #colors: BufferAttribute;

  constructor(public worn: Worn, private readonly solids: Solids) {
    const { vertices, faces, palette } = worn.coat;
    const places = Float32Array.from(vertices ? ofArray(vertices) : []), rows = Uint32Array.from(faces ? ofArray(faces) : []);
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
    geometry.setIndex(new BufferAttribute(rows, 1));
    geometry.computeVertexNormals();
    // A little nearer to the eye than the surface that it lies on.
    const material = new MeshStandardMaterial({ vertexColors: true, roughness: ROUGHNESS, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 });
    super(geometry, material);
    this.#faces = rows;
    this.#palette = linear(palette);
    this.#shown = new BufferAttribute(rows.slice(), 1).setUsage(DynamicDrawUsage);
    this.#colors = new BufferAttribute(new Float32Array(places.length), 3).setUsage(DynamicDrawUsage);
    geometry.setIndex(this.#shown).setAttribute("color", this.#colors);
    this.receiveShadow = true;
    this.frustumCulled = false;
  }

  /** Shows other values. */
  paint(worn: Worn): void {
    this.worn = worn;
    const { values } = worn, colors = this.#colors.array, shown = this.#shown.array, faces = this.#faces;
    for (let corner = 0; corner < values.length; corner++) {
      const at = 3 * values[corner];
      for (let part = 0; part < 3; part++) colors[3 * corner + part] = this.#palette[at + part];
    }
    let count = 0;
    for (let at = 0; at < faces.length; at += 3) {
      const a = faces[at], b = faces[at + 1], c = faces[at + 2];
      if (!values[a] || !values[b] || !values[c]) continue;
      shown[count++] = a;
      shown[count++] = b;
      shown[count++] = c;
    }
    this.geometry.setDrawRange(0, count);
    this.#colors.needsUpdate = this.#shown.needsUpdate = true;
  }

  override updateMatrixWorld(): void {
    const name = names.get(this.worn.coat.nodeUid) ?? "", place = this.solids.places.get(name);
    this.visible = place !== undefined && this.solids.isShown(name);
    if (place) this.matrixWorld.copy(place);
  }
}

/** Returns the colours of the values 0 to 255 as light. */
function linear(palette: Uint8Array): Float32Array {
  const color = new Color(), found = new Float32Array(3 * COLORS);
  for (let value = 0; value < COLORS; value++) {
    const [red, green, blue] = palette.subarray(3 * value, 3 * value + 3);
    color.setRGB(red / 255, green / 255, blue / 255, "srgb").toArray(found, 3 * value);
  }
  return found;
}
