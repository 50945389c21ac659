// Axes and corners of bodies, found by a point on their triangles: of the hole or the pin whose wall is there, or of an edge that is near; and bodies apart.
import { Vector3, type BufferGeometry, type Matrix4 } from "three";

export interface Axis {
  kind: "hole" | "pin" | "round edge" | "straight edge" | "frame axis";
  /** In the middle of what it is the axis of. */
  point: Vector3;
  direction: Vector3;
  /** Meters; 0 of what is straight. */
  radius: number;
  /** Meters along the axis; 0 of a round edge and of a frame's axis. */
  length: number;
}

/** Triangles, and where they are. */
export interface Placed {
  geometry: BufferGeometry;
  local: Matrix4;
}

interface Circle {
  center: Vector3;
  radius: number;
}

/** Corners nearer than this are one: meshes for drawing have one for each normal. */
const WELD_METERS = 1e-6;
/** From this angle on two triangles meet in an edge; round walls have smaller ones between theirs. */
const SHARP = Math.cos((40 * Math.PI) / 180);
const FLAT = Math.cos((0.5 * Math.PI) / 180);
/** How far, of the radius, corners may be off a circle of few of them, and of the one through all. */
const LOOSE = 0.02, TIGHT = 0.002, LEAST_METERS = 2e-5;
/** Sine of the angle by which a wall may lean over its axis. */
const LEAN = 0.02;
const MOST_WALLS = 6;
/** For keys of edges, which are two corners. */
const MOST_CORNERS = 2 ** 26;

export class Surface {
  #corners: Vector3[] = [];
  #triangles: (readonly number[])[] = [];
  #normals: Vector3[] = [];
  /** How many triangles there are up to the end of each part. */
  #ends: number[] = [];
  /** Triangles beside each edge, by the key of its corners. */
  #beside = new Map<number, number[]>();
  /** Corners at the other ends of sharp edges. */
  #sharp = new Map<number, number[]>();

  /** Reads triangles (m) of parts, each placed by a matrix, and numbers them one part after the other. */
  constructor(parts: readonly Placed[]) {
    const known = new Map<string, number>();
    for (const { geometry, local } of parts) {
      const { index } = geometry, positions = geometry.getAttribute("position");
      const numbers = Array.from({ length: positions.count }, (_, at) => {
        const corner = new Vector3().fromBufferAttribute(positions, at).applyMatrix4(local);
        const key = corner.toArray().map((value) => Math.round(value / WELD_METERS)).join(" ");
        if (!known.has(key)) known.set(key, this.#corners.push(corner) - 1);
        return known.get(key)!;
      });
      const count = index?.count ?? positions.count;
      for (let at = 0; at < count; at += 3) this.#add([0, 1, 2].map((one) => numbers[index ? index.getX(at + one) : at + one]));
      this.#ends.push(this.#triangles.length);
    }
    for (const key of this.#beside.keys()) {
      const [first, second] = endsOf(key);
      if (this.#isSmooth(key)) continue;
      for (const [one, other] of [[first, second], [second, first]]) this.#sharp.set(one, [...(this.#sharp.get(one) ?? []), other]);
    }
  }

  /** Returns the axis at a point of a triangle: of the nearest edge within reach (m), or else of the wall; undefined for none. */
  axisAt(triangle: number, point: Vector3, reach: number): Axis | undefined {
    const edge = this.#edgeNear(point, reach);
    return edge ? this.#axisOfEdge(...edge) : this.#axisOfWall(triangle);
  }

  /** Returns the nearest corner of the body within reach (m): where sharp edges meet, end, or turn. */
  cornerNear(point: Vector3, reach: number): Vector3 | undefined {
    let found: Vector3 | undefined, least = reach;
    for (const [corner, ends] of this.#sharp) {
      const distance = this.#corners[corner].distanceTo(point);
      if (distance >= least) continue;
      if (ends.length === 2 && this.#step(ends[0], corner).dot(this.#step(corner, ends[1])) > SHARP) continue;
      [found, least] = [this.#corners[corner], distance];
    }
    return found;
  }

  /** Returns the bodies, which are triangles that hang together by edges: of each the corners of its triangles, by part. */
  bodies(): Map<number, Vector3[]>[] {
    const left = new Set(this.#triangles.keys()), found: Map<number, Vector3[]>[] = [];
    for (const begin of left) {
      if (new Set(this.#triangles[begin]).size < 3) continue;
      const body = new Set([begin]);
      for (const one of body) for (const key of this.#edges(this.#triangles[one])) for (const other of this.#mates(key, one)) body.add(other);
      const parts = new Map<number, Vector3[]>();
      for (const one of body) {
        left.delete(one);
        const part = this.#ends.findIndex((end) => one < end);
        if (!parts.has(part)) parts.set(part, []);
        parts.get(part)!.push(...this.#triangles[one].map((corner) => this.#corners[corner]));
      }
      found.push(parts);
    }
    return found;
  }

  /** Returns the triangle of the same body beyond an edge: where bodies touch along it, the nearest one through the inside. */
  #mates(edge: number, triangle: number): number[] {
    const others = (this.#beside.get(edge) ?? []).filter((one) => one !== triangle);
    if (others.length <= 1) return others;
    const normal = this.#normals[triangle], along = this.#along(edge, triangle), into = normal.clone().cross(along);
    const turns = others.filter((one) => this.#along(edge, one).dot(along) < 0).map((one) => {
      const there = this.#normals[one].clone().cross(this.#along(edge, one));
      const turn = Math.atan2(-there.dot(normal), there.dot(into));
      return [turn > 1e-6 ? turn : turn + 2 * Math.PI, one] as const;
    });
    return turns.sort(([one], [other]) => one - other).slice(0, 1).map(([, one]) => one);
  }

  /** Returns the direction in which a triangle, seen from outside to the left around, goes along an edge of it. */
  #along(edge: number, triangle: number): Vector3 {
    const [first, second] = endsOf(edge), corners = this.#triangles[triangle];
    return corners[(corners.indexOf(first) + 1) % 3] === second ? this.#step(first, second) : this.#step(second, first);
  }

  #add(triangle: readonly number[]): void {
    const [a, b, c] = triangle.map((corner) => this.#corners[corner]);
    const number = this.#triangles.push(triangle) - 1;
    this.#normals.push(b.clone().sub(a).cross(c.clone().sub(a)).normalize());
    if (new Set(triangle).size < 3) return;
    for (const key of this.#edges(triangle)) this.#beside.set(key, [...(this.#beside.get(key) ?? []), number]);
  }

  #edges([a, b, c]: readonly number[]): number[] {
    return [[a, b], [b, c], [c, a]].map(([one, other]) => Math.min(one, other) * MOST_CORNERS + Math.max(one, other));
  }

  #isSmooth(edge: number): boolean {
    const beside = this.#beside.get(edge)!;
    return beside.length === 2 && this.#normals[beside[0]].dot(this.#normals[beside[1]]) > SHARP;
  }

  #edgeNear(point: Vector3, reach: number): [number, number] | undefined {
    let found: [number, number] | undefined, least = reach;
    for (const [first, ends] of this.#sharp) {
      for (const second of ends) {
        if (first > second) continue;
        const from = this.#corners[first], along = this.#corners[second].clone().sub(from);
        const part = Math.min(1, Math.max(0, point.clone().sub(from).dot(along) / along.lengthSq()));
        const distance = along.multiplyScalar(part).add(from).distanceTo(point);
        if (distance < least) [found, least] = [[first, second], distance];
      }
    }
    return found;
  }

  #axisOfEdge(first: number, second: number): Axis {
    const chain = this.#chain(first, second), seed = chain.indexOf(first);
    const points = chain.map((corner) => this.#corners[corner]);
    const rounds = [seed - 1, seed].flatMap((start) => arcOf(points, start) ?? []).sort((one, other) => other.count - one.count);
    if (rounds.length > 0) {
      const { circle, direction } = rounds[0];
      return { kind: "round edge", point: circle.center, direction, radius: circle.radius, length: 0 };
    }
    const [from, to] = [points[seed], points[seed + 1]], direction = to.clone().sub(from).normalize();
    const isOn = (one: Vector3) => one.clone().sub(from).cross(direction).length() < LEAST_METERS;
    const [begin, end] = grown(points, seed, seed + 1, isOn).map((at) => points[at]);
    return { kind: "straight edge", point: begin.clone().lerp(end, 0.5), direction, radius: 0, length: begin.distanceTo(end) };
  }

  /** Returns the corners of sharp edges in a row that turn little; the seed's two stand beside each other, those of a loop in the middle. */
  #chain(first: number, second: number): number[] {
    const ahead = this.#row(first, second);
    if (ahead.at(-1) === first) {
      const half = ahead.length >> 1;
      return [...ahead.slice(half, -1), first, ...ahead.slice(0, half)];
    }
    return [...this.#row(second, first).reverse(), ...ahead];
  }

  /** Returns the corners after `from`, until there is a corner of the body, or `from` again. */
  #row(from: number, to: number): number[] {
    const row = [to];
    for (let before = from; row.length <= this.#corners.length; ) {
      const here = row.at(-1)!, along = this.#step(before, here);
      const ways = (this.#sharp.get(here) ?? []).filter((one) => one !== before).map((one) => [this.#step(here, one).dot(along), one] as const);
      const [straight, next] = ways.sort(([one], [other]) => other - one)[0] ?? [0, 0];
      if (straight < SHARP) break;
      row.push(next);
      if (next === from) break;
      before = here;
    }
    return row;
  }

  #step(from: number, to: number): Vector3 {
    return this.#corners[to].clone().sub(this.#corners[from]).normalize();
  }

  /** Returns the axis of the cylinder whose wall a triangle belongs to. */
  #axisOfWall(triangle: number): Axis | undefined {
    const flat = this.#spread([triangle], (one) => this.#normals[one].dot(this.#normals[triangle]) > FLAT);
    const beside = [...new Set([...flat].flatMap((one) => this.#smoothlyBeside(one)))].filter((one) => !flat.has(one));
    const walls = beside.slice(0, MOST_WALLS).flatMap((one) => this.#wall(triangle, [...flat, one], one) ?? []);
    return walls.sort((one, other) => other.count - one.count)[0]?.axis;
  }

  #wall(triangle: number, begin: readonly number[], other: number): { axis: Axis; count: number } | undefined {
    const normal = this.#normals[triangle];
    const direction = normal.clone().cross(this.#normals[other]).normalize();
    const first = circleOf(this.#cornersOf(begin), direction);
    if (!first) return undefined;
    const isOn = (one: number) => Math.abs(this.#normals[one].dot(direction)) < LEAN && this.#cornersOf([one]).every((corner) => isNear(corner, first, direction, LOOSE));
    const wall = this.#spread(begin.filter(isOn), isOn);
    if (!wall.has(triangle)) return undefined;
    // Its direction by all of it: triangles a quarter apart tell it best.
    const sum = new Vector3();
    for (const one of wall) {
      const across = normal.clone().cross(this.#normals[one]);
      sum.addScaledVector(across, across.dot(direction) < 0 ? -1 : 1);
    }
    const axis = sum.normalize(), corners = this.#cornersOf([...wall]);
    const circle = circleOf(corners, axis);
    if (!circle || !corners.every((corner) => isNear(corner, circle, axis, TIGHT))) return undefined;
    const heights = corners.map((corner) => corner.clone().sub(circle.center).dot(axis));
    const low = Math.min(...heights), high = Math.max(...heights);
    const outwards = this.#cornersOf([triangle])[0].clone().sub(circle.center).dot(normal) > 0;
    const point = circle.center.clone().addScaledVector(axis, (low + high) / 2);
    return { axis: { kind: outwards ? "pin" : "hole", point, direction: axis, radius: circle.radius, length: high - low }, count: wall.size };
  }

  /** Returns the triangles that are reached from these over smooth edges through those that belong to them. */
  #spread(from: readonly number[], belongs: (triangle: number) => boolean): Set<number> {
    const found = new Set(from);
    for (const one of found) for (const other of this.#smoothlyBeside(one)) if (!found.has(other) && belongs(other)) found.add(other);
    return found;
  }

  #smoothlyBeside(triangle: number): number[] {
    const edges = this.#edges(this.#triangles[triangle]).filter((key) => this.#beside.has(key) && this.#isSmooth(key));
    return edges.flatMap((key) => this.#beside.get(key)!).filter((one) => one !== triangle);
  }

  #cornersOf(triangles: readonly number[]): Vector3[] {
    return [...new Set(triangles.flatMap((one) => this.#triangles[one]))].map((corner) => this.#corners[corner]);
  }
}

/** Returns the arc of points in a row that begins with the three at `start`; undefined where fewer than four are on it. */
function arcOf(points: readonly Vector3[], start: number): { circle: Circle; direction: Vector3; count: number } | undefined {
  if (start < 0 || start + 2 >= points.length) return undefined;
  const [a, b, c] = points.slice(start, start + 3);
  const direction = b.clone().sub(a).cross(c.clone().sub(b));
  if (direction.length() < 1e-6 * a.distanceTo(b) * b.distanceTo(c)) return undefined;
  direction.normalize();
  const first = circleOf([a, b, c], direction);
  if (!first) return undefined;
  const isOn = (one: Vector3) => isNear(one, first, direction, LOOSE) && Math.abs(one.clone().sub(a).dot(direction)) < LOOSE * first.radius + LEAST_METERS;
  const [begin, end] = grown(points, start, start + 2, isOn);
  const arc = points.slice(begin, end + 1);
  // By Newell's sum over the whole arc: neighbours alone tell a direction badly.
  const sum = arc.slice(2).reduce((all, one, at) => all.add(arc[at + 1].clone().sub(arc[0]).cross(one.clone().sub(arc[0]))), new Vector3()).normalize();
  const circle = circleOf(arc, sum);
  if (!circle || arc.length < 4 || !arc.every((one) => isNear(one, circle, sum, TIGHT))) return undefined;
  return { circle, direction: sum, count: arc.length };
}

/** Returns the widest range about a range of points in a row all of which satisfy a condition. */
function grown(points: readonly Vector3[], begin: number, end: number, isOn: (point: Vector3) => boolean): [number, number] {
  while (begin > 0 && isOn(points[begin - 1])) begin--;
  while (end + 1 < points.length && isOn(points[end + 1])) end++;
  return [begin, end];
}

function endsOf(edge: number): [number, number] {
  return [Math.floor(edge / MOST_CORNERS), edge % MOST_CORNERS];
}

function isNear(point: Vector3, { center, radius }: Circle, direction: Vector3, share: number): boolean {
  const off = point.clone().sub(center);
  return Math.abs(off.addScaledVector(direction, -off.dot(direction)).length() - radius) < share * radius + LEAST_METERS;
}

/** Returns the circle through points as they are seen along a direction, by least squares of its equation (I. Kåsa, 1976). */
function circleOf(points: readonly Vector3[], direction: Vector3): Circle | undefined {
  const mean = points.reduce((sum, one) => sum.add(one), new Vector3()).divideScalar(points.length);
  const u = new Vector3(...(Math.abs(direction.x) < 0.7 ? [1, 0, 0] : [0, 1, 0])).cross(direction).normalize(), v = direction.clone().cross(u);
  let [uu, uv, vv, ru, rv] = [0, 0, 0, 0, 0];
  for (const one of points) {
    const off = one.clone().sub(mean), x = off.dot(u), y = off.dot(v), square = x * x + y * y;
    uu += x * x;
    uv += x * y;
    vv += y * y;
    ru += (x * square) / 2;
    rv += (y * square) / 2;
  }
  const det = uu * vv - uv * uv;
  if (det < 1e-12 * (uu + vv) ** 2) return undefined;
  const x = (ru * vv - rv * uv) / det, y = (rv * uu - ru * uv) / det;
  return { center: mean.addScaledVector(u, x).addScaledVector(v, y), radius: Math.sqrt(x * x + y * y + (uu + vv) / points.length) };
}
