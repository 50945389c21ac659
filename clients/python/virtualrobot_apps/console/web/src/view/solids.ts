// What the world's nodes look like and where they are: their figures, what is selected, and marks of what has no figure.
import { Box3, Matrix4, type Object3D, type Raycaster } from "three";
import { outlined } from "../kernel/collisions";
import * as world from "../kernel/world";
import { Batches, type Hit } from "./batches";
import { Silhouette } from "./copies";
import { contentOf, primitive, seen, type Piece } from "./figures";
import { Marks } from "./marks";
import { Meshes } from "./meshes";
import { readRow } from "./poses";

const SELECTED = 0x3b9eff;
const MARKED = 0xff2e63;

export class Solids {
  readonly places = new Map<string, Matrix4>();
  readonly pieces = new Map<string, readonly Piece[]>();
  readonly objects: Object3D[];
  /** Whether all meshes of what there is are here. */
  isComplete = false;
  #batches = new Batches();
  #silhouette = new Silhouette(SELECTED);
  #marked = new Silhouette(MARKED);
  #marks = new Marks();
  #meshes = new Meshes(() => this.#restructure());
  #alone = "";
  #shown: ReadonlySet<string> = new Set();
  #moved = true;
  #structure = true;

  /** `changed` is called when there is something else to be drawn. */
  constructor(private readonly changed: () => void) {
    this.objects = [this.#batches.group, this.#silhouette.group, this.#marked.group, this.#marks.group];
    world.hearers.poses.add((uids, rows) => this.#takePoses(uids, rows));
    world.hearers.structure.add((renamed) => this.#rename(renamed));
  }

  /** Makes and puts in place what has changed since the last picture; returns whether nodes came, went or changed. */
  update(): boolean {
    const structure = this.#structure;
    if (structure) this.#rebuild();
    if (this.#moved) this.#place();
    return structure;
  }

  select(name: string): void {
    const item = world.items.peek().get(name);
    const names = item && item.kind !== "world" ? world.below(name) : [];
    this.#silhouette.show(names, this.pieces, this.places);
    this.#moved = true;
    this.changed();
  }

  /** Shows a node alone, with what hangs below it; "" shows all. */
  isolate(name: string): void {
    this.#alone = name;
    this.#restructure();
  }

  /** Marks these nodes, without what hangs below them, and no others. */
  mark(names: readonly string[]): void {
    this.#marked.show(names, this.pieces, this.places);
    this.changed();
  }

  /** Returns the box around the figures of nodes, in the world. */
  boxOf(names: Iterable<string>): Box3 {
    const box = new Box3();
    for (const one of names) {
      const place = this.places.get(one);
      for (const { geometry, local } of (place && this.pieces.get(one)) || []) {
        geometry.computeBoundingBox();
        box.union(geometry.boundingBox!.clone().applyMatrix4(new Matrix4().multiplyMatrices(place!, local)));
      }
    }
    return box;
  }

  /** Returns whether a node is neither hidden nor left out. */
  isShown(name: string): boolean {
    return this.#shown.has(name);
  }

  /** Draws what nodes look like and the rim of what is selected, or leaves that to somebody else; marks stay. */
  setDrawn(drawn: boolean): void {
    this.#batches.group.visible = this.#silhouette.group.visible = drawn;
  }

  /** Returns what a ray meets first. */
  hit(ray: Raycaster): Hit | undefined {
    return this.#batches.hit(ray);
  }

  setSize(width: number, height: number): void {
    this.#silhouette.setSize(width, height);
    this.#marked.setSize(width, height);
  }

  #restructure(): void {
    this.#structure = true;
    this.changed();
  }

  #rename(renamed: world.Renamed): void {
    const moved = [...renamed].map(([from, to]) => [to, this.places.get(from)] as const);
    for (const from of renamed.keys()) this.places.delete(from);
    for (const [to, place] of moved) if (place) this.places.set(to, place);
    this.#restructure();
  }

  #takePoses(uids: readonly bigint[], rows: Float64Array): void {
    uids.forEach((uid, place) => {
      const name = world.names.get(uid);
      if (name === undefined) return;
      let matrix = this.places.get(name);
      if (matrix === undefined) this.places.set(name, (matrix = new Matrix4()));
      readRow(rows, place, matrix);
    });
    this.#moved = true;
    this.changed();
  }

  #rebuild(): void {
    this.#structure = false;
    this.pieces.clear();
    const missing = new Map<string, string[]>();
    const alone = this.#alone && new Set(world.below(this.#alone));
    const shown = [...world.items.peek().values()].filter((item) => !isHidden(item) && (!alone || alone.has(item.name)));
    this.#shown = new Set(shown.map(({ name }) => name));
    for (const item of shown) {
      const found: Piece[] = [];
      for (const figure of seen(item)) {
        const one = primitive(figure);
        if (one) found.push(one);
        else if (figure.geometry.case === "mesh") {
          const parts = this.#meshes.piecesOf(figure);
          if (parts) found.push(...parts);
          else {
            const root = world.robotOf(item.name) || item.name;
            missing.set(root, [...(missing.get(root) ?? []), contentOf(figure)]);
          }
        }
      }
      if (found.length > 0) this.pieces.set(item.name, found);
    }
    if (missing.size > 0) void this.#meshes.want(missing);
    this.#batches.rebuild(this.pieces);
    this.#marks.rebuild(shown);
    this.select(world.selected.peek());
    this.mark(outlined.peek());
    this.isComplete = missing.size === 0 && shown.length > 0;
  }

  #place(): void {
    this.#moved = false;
    this.#batches.place(this.places);
    this.#silhouette.place(this.places);
    this.#marked.place(this.places);
    this.#marks.place(this.places);
  }
}

function isHidden(item: world.Item): boolean {
  for (let one: world.Item | undefined = item; one; one = world.items.peek().get(one.parent)) if (one.hidden) return true;
  return false;
}
