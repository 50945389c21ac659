// The registered room, kept by the headset: an anchor stays at a place of the real room, through sessions, and as the headset
// comes to know better where it is itself.
import { Matrix4, Vector3 } from "three";

const KEY = "virtualrobot-anchor";
/** Elements of poses (m, or parts of a turn) that differ by less are the same. */
const SAME = 1e-4;

interface Kept {
  handle: string;
  /** Column by column. */
  world_t_anchor: number[];
}

export class RoomAnchor {
  #anchor?: XRAnchor;
  #world_t_anchor = new Matrix4();
  #wanted?: { world_t_room: Matrix4; point: Vector3 };
  #last?: Matrix4;

  /** Takes up the anchor that an earlier session has kept, where `isKnown` says that the cell is the same. */
  constructor(private readonly session: XRSession, isKnown: boolean) {
    if (isKnown) void this.#restore();
  }

  /** Keeps a room from the next picture on, by a point of it. */
  keep(world_t_room: Matrix4, point: Vector3): void {
    this.#wanted = { world_t_room: world_t_room.clone(), point: point.clone() };
  }

  /** Returns how the room lies in the world by the anchor, where that is another way than the last time. */
  follow(frame: XRFrame, room: XRReferenceSpace): Matrix4 | undefined {
    if (this.#wanted) void this.#make(frame, room);
    const pose = this.#anchor && frame.getPose(this.#anchor.anchorSpace, room);
    if (!pose) return undefined;
    const world_t_room = this.#world_t_anchor.clone().multiply(new Matrix4().fromArray(pose.transform.inverse.matrix));
    if (this.#last?.elements.every((value, place) => Math.abs(value - world_t_room.elements[place]) < SAME)) return undefined;
    return (this.#last = world_t_room);
  }

  async #make(frame: XRFrame, room: XRReferenceSpace): Promise<void> {
    const { world_t_room, point } = this.#wanted!;
    this.#wanted = undefined;
    this.#anchor = undefined;
    try {
      const anchor = await frame.createAnchor?.(new XRRigidTransform({ x: point.x, y: point.y, z: point.z }), room);
      if (!anchor) return;
      this.#world_t_anchor = world_t_room.clone().multiply(new Matrix4().makeTranslation(point));
      this.#last = world_t_room;
      this.#anchor = anchor;
      const handle = await anchor.requestPersistentHandle?.();
      const kept: Kept | undefined = handle ? { handle, world_t_anchor: this.#world_t_anchor.toArray() } : undefined;
      if (kept) localStorage.setItem(KEY, JSON.stringify(kept));
    } catch {
      // Without anchors the room is where it was touched, as long as the session lasts.
    }
  }

  async #restore(): Promise<void> {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "null") as Kept | null;
    if (!kept) return;
    try {
      const anchor = await this.session.restorePersistentAnchor?.(kept.handle);
      if (!anchor || this.#anchor || this.#wanted) return;
      this.#world_t_anchor.fromArray(kept.world_t_anchor);
      this.#anchor = anchor;
    } catch {
      localStorage.removeItem(KEY); // the headset has forgotten it
    }
  }
}
