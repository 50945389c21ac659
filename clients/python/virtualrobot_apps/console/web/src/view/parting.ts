// The bodies of one node's files, taken apart: each becomes a node that hangs on it.
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { SRGBColorSpace, type Color, type Vector3 } from "three";
import { FigureSchema, MeshSchema } from "../generated/virtualrobot/v1/nodes_pb";
import { attempt, say } from "../kernel/messages";
import { apply } from "../kernel/orders";
import { uploadAll } from "../kernel/uploads";
import { items } from "../kernel/world";
import { Surface } from "./axes";
import type { Viewport } from "./viewport";

const MOST = 200;
const HEAD_BYTES = 84, TRIANGLE_BYTES = 50;

/** Makes each body of a node that has several a node below it, in its place and colours, as one step of the history. */
export async function takeApart({ solids }: Viewport, name: string): Promise<boolean> {
  const item = items.peek().get(name), pieces = solids.pieces.get(name) ?? [];
  const bodies = new Surface(pieces).bodies();
  if (!item || bodies.length < 2 || bodies.length > MOST) {
    say(bodies.length > MOST ? `${name} has ${bodies.length} bodies; up to ${MOST} are taken apart` : `${name} has no two bodies that can be taken apart`, "warning");
    return false;
  }
  const kind = item.kind === "part" ? { case: "part" as const, value: {} } : { case: "object" as const, value: {} };
  const made: MessageInitShape<typeof FigureSchema>[][] = [];
  for (const [number, parts] of bodies.entries()) {
    const figures = [];
    for (const [part, corners] of parts) {
      const uri = `body-${number + 1}-${part + 1}.stl`;
      const sent = await attempt(uploadAll(new Map([[uri, new File([stl(corners)], uri)]]), uri, { signal: new AbortController().signal, tell: () => {} }));
      if (!sent) return false;
      const { color, material } = pieces[part];
      const [red, green, blue] = rgb(color ?? material.color);
      figures.push({ geometry: { case: "mesh" as const, value: create(MeshSchema, { uri, sha256: sent.get(uri) }) }, material: { color: { red, green, blue } } });
    }
    made.push(figures);
  }
  const names = freeNames(name, made.length);
  const done = await apply(
    { case: "updateNode", value: { name, node: { figures: [] }, updateMask: { paths: ["figures"] } } },
    ...made.map((figures, at) => ({ case: "createNode" as const, value: { node: { name: names[at], parent: name, figures, kind } } })),
  );
  if (done) say(`${name} has ${made.length} bodies, from ${names[0]} to ${names.at(-1)}`, "good");
  return done;
}

function rgb(color: Color): [number, number, number] {
  const { r, g, b } = color.getRGB({ r: 0, g: 0, b: 0 }, SRGBColorSpace);
  return [r, g, b];
}

/** Returns a binary STL file of triangles; its normals are left to its reader. */
function stl(corners: readonly Vector3[]): ArrayBuffer {
  const bytes = new ArrayBuffer(HEAD_BYTES + (TRIANGLE_BYTES * corners.length) / 3), view = new DataView(bytes);
  view.setUint32(HEAD_BYTES - 4, corners.length / 3, true);
  corners.forEach((corner, number) => {
    const at = HEAD_BYTES + TRIANGLE_BYTES * Math.floor(number / 3) + 12 * (1 + (number % 3));
    corner.toArray().forEach((value, axis) => view.setFloat32(at + 4 * axis, value, true));
  });
  return bytes;
}

function freeNames(name: string, count: number): string[] {
  const found: string[] = [];
  for (let number = 1; found.length < count; number++) if (!items.peek().has(`${name} ${number}`)) found.push(`${name} ${number}`);
  return found;
}
