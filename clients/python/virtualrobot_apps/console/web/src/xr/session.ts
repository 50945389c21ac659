// The cell in a room: an immersive session of this page, its frames, and what hands do in it.
import { signal } from "@preact/signals";
import { Group, Matrix4, PerspectiveCamera, Vector3, type Object3D } from "three";
import { say } from "../kernel/messages";
import { teach } from "../kernel/orders";
import { stop } from "../kernel/stop";
import { showHead } from "../kernel/viewers";
import { viewpointOf } from "../kernel/viewpoints";
import { chosen, items } from "../kernel/world";
import { tool } from "../view/gizmo";
import type { Room, Viewport } from "../view/viewport";
import { RoomAnchor } from "./anchor";
import { DrawnCell } from "./drawn_cell";
import { Fingertips } from "./fingertips";
import { Handle, rayOf } from "./handle";
import { isMomentary, readHands, type Hand } from "./hands";
import { settings } from "./observer";
import { Panel, type Press } from "./panel";
import { Pointers } from "./pointers";
import { proposal } from "./proposal";
import { KEPT, registration } from "./registration";
import { AHEAD_METERS, roomInWorld, walked } from "./rig";
import { resized, scale, scaleOf, stepFrom, Stretch } from "./scale";
import { ShownWay } from "./shown_way";
import { reasonOf, type Mode } from "./support";
import { leads, teleop } from "./teleop";

/** The room that this page is shown in; undefined for none, and while one is asked for. */
export const entered = signal<Immersion | undefined>(undefined);

const FEATURES = { requiredFeatures: ["local-floor"], optionalFeatures: ["hand-tracking", "anchors"] };
const NAMES: Record<Mode, string> = { "immersive-ar": "augmented reality", "immersive-vr": "virtual reality" };
/** A page that has stood still for so long (ms) has let go: the trigger is to be pressed anew. */
const HANG_MS = 500;
/** The whole way in so many seconds, with the stick at its end. */
const SCRUB_SECONDS = 2;
const DEAD_STICK = 0.2;
/** With the stick at its end a person turns so far at once, where the whole room is virtual. */
const TURN = Math.PI / 6, TURN_STICK = 0.7;

/** A hand whose grip and ray are in the world; its tip is in the room. */
type Near = Hand & { pointed?: Press; distance?: number };
type Buttons = Pick<Hand, "trigger" | "squeeze" | "back">;

const NOTHING: Buttons = { trigger: false, squeeze: false, back: false };
let asked = false;

/** Shows the cell in a room, where the browser and the person at it allow that. */
export async function enter(view: Viewport, mode: Mode): Promise<void> {
  if (asked || entered.peek()) return;
  asked = true;
  let session: XRSession | undefined;
  try {
    // Nothing is awaited before: browsers want to see the press of the button.
    session = await navigator.xr!.requestSession(mode, FEATURES);
    const room = new Immersion(view, mode, session);
    try {
      await view.stage.renderer.xr.setSession(session);
    } catch (error) {
      room.dispose();
      throw error;
    }
    if (view.room === room) entered.value = room;
  } catch (error) {
    say(`no ${NAMES[mode]}: ${reasonOf(error)}`, "error");
    await session?.end().catch(() => {}); // it has ended already
  } finally {
    asked = false;
  }
}

export class Immersion implements Room {
  /** The room in the world: what hangs in it goes along with it. */
  #rig = new Group();
  #camera = new PerspectiveCamera(60, 1, settings.peek().near, settings.peek().far);
  #panel = new Panel();
  #pointers = new Pointers();
  #handle = new Handle();
  #fingertips = new Fingertips();
  #way: ShownWay;
  #cell: DrawnCell;
  #stretch = new Stretch();
  #anchor: RoomAnchor;
  #isPlaced = false;
  /** How high (m) the floor of the room is over that of the world, in life size. */
  #floor = 0;
  /** How the room lay in the world before the cell had another size. */
  #lifeSize?: Matrix4;
  /** What was pressed in the frame before, of each source. */
  #before = new Map<XRInputSource, Buttons>();
  /** Whose trigger holds the motion. */
  #holder?: XRInputSource;
  /** Side to which the stick that turns was pushed in the frame before. */
  #leaned = 0;
  #time = 0;

  constructor(private readonly view: Viewport, readonly mode: Mode, private readonly session: XRSession) {
    const { scene, renderer } = view.stage;
    this.#way = new ShownWay(view);
    this.#anchor = new RoomAnchor(session, mode === "immersive-ar" && items.peek().has(KEPT));
    this.#cell = new DrawnCell(view.solids);
    this.#rig.matrixAutoUpdate = false;
    this.#rig.add(this.#camera, this.#panel.mesh);
    scene.add(...this.#objects);
    view.stage.enter(mode === "immersive-ar");
    view.room = this;
    view.ghost.group.visible = false;
    view.solids.setDrawn(false);
    tool.value = "select";
    proposal.isSeen.value = true;
    // After the renderer's own end of it, which gives the picture its size again.
    renderer.xr.addEventListener("sessionend", this.#ended);
    session.addEventListener("visibilitychange", () => session.visibilityState !== "visible" && this.#letGo());
  }

  leave(): void {
    void this.session.end();
  }

  rebuild(): void {
    this.#way.rebuild();
    this.#cell.rebuild();
  }

  draw(frame: XRFrame): void {
    const { renderer, scene } = this.view.stage, space = renderer.xr.getReferenceSpace(), now = performance.now();
    const seconds = Math.min(now - this.#time, HANG_MS) / 1000;
    if (now - this.#time > HANG_MS) this.#letGo();
    this.#time = now;
    const head = space && frame.getViewerPose(space);
    if (!space || !head) return this.#letGo();
    this.#place(new Matrix4().fromArray(head.transform.matrix));
    this.#settle(this.#anchor.follow(frame, space));
    const seen = frame.session.visibilityState === "visible" ? readHands(frame, space) : [];
    this.#resize(seen);
    const hands = seen.map((one) => this.#near(one));
    this.#act(hands, now, seconds);
    if (this.mode === "immersive-vr") this.#walk(hands, new Matrix4().fromArray(head.transform.matrix), seconds);
    this.#handle.follow();
    showHead(this.#rig.matrix.clone().multiply(new Matrix4().fromArray(head.transform.matrix)), scale.peek());
    this.#way.advance();
    this.#cell.advance();
    this.#pointers.show(hands, scale.peek());
    this.#panel.draw(new Set(hands.flatMap(({ pointed }) => pointed ?? [])), this.#holder !== undefined);
    renderer.autoClear = true;
    renderer.render(scene, this.#camera);
  }

  /** Takes all of it out of the scene, and shows the page again. */
  dispose(): void {
    if (this.view.room !== this) return;
    const { stage, ghost, solids } = this.view;
    stage.renderer.xr.removeEventListener("sessionend", this.#ended);
    stage.scene.remove(...this.#objects);
    for (const one of [this.#panel, this.#pointers, this.#handle, this.#way, this.#cell]) one.dispose();
    ghost.group.visible = true;
    solids.setDrawn(true);
    stage.leave();
    this.view.leaveRoom();
  }

  get #objects(): Object3D[] {
    return [this.#rig, this.#handle.group, this.#pointers.group, this.#way.group, this.#cell.group];
  }

  readonly #ended = () => {
    this.#letGo();
    registration.stop();
    proposal.leave("the person has left the room");
    leads.value = false;
    scale.value = 1;
    entered.value = undefined;
    showHead(undefined);
    this.dispose();
  };

  /** Lays the room into the world when it is first known where the head is, with the chosen robot ahead. */
  #place(room_t_head: Matrix4): void {
    if (!this.#isPlaced) {
      this.#isPlaced = true;
      const { camera } = this.view.observer, base = this.view.solids.places.get(chosen.peek()) ?? new Matrix4();
      camera.updateMatrixWorld();
      const { height } = settings.peek(), from = this.#entrance();
      this.#floor = this.mode === "immersive-vr" && height > 0 ? height - room_t_head.elements[13] : 0;
      this.#rig.matrix.copy(from ? roomInWorld(room_t_head, ...from) : roomInWorld(room_t_head, camera.matrixWorld, new Vector3().setFromMatrixPosition(base)));
      this.#rig.matrix.elements[14] = this.#floor;
    }
    this.#panel.place(room_t_head);
    this.#rig.updateMatrixWorld(true);
  }

  /** Returns the eye of the saved view from which the cell is entered, and the point so far ahead of it as a robot is. */
  #entrance(): [world_t_eye: Matrix4, ahead: Vector3] | undefined {
    const item = items.peek().get(settings.peek().pose), place = item && this.view.solids.places.get(item.name);
    const found = place && viewpointOf(item, place);
    if (!found) return undefined;
    const position = new Vector3(...found.position), target = new Vector3(...found.target), up = new Vector3(0, 0, 1);
    const ahead = target.clone().sub(position).setZ(0);
    if (ahead.lengthSq() === 0) return undefined;
    return [new Matrix4().lookAt(position, target, up), position.addScaledVector(ahead.normalize(), AHEAD_METERS)];
  }

  /** Lays the room as the anchor has it: at once in life size, and else when life size comes again. */
  #settle(world_t_room: Matrix4 | undefined): void {
    if (!world_t_room) return;
    if (scale.peek() === 1) this.#lay(world_t_room);
    else this.#lifeSize = world_t_room.clone();
  }

  #near(hand: Hand): Near {
    const inWorld = (pose: Matrix4 | undefined) => pose && this.#rig.matrix.clone().multiply(pose);
    const grip = inWorld(hand.grip), ray = inWorld(hand.ray), met = ray && this.#panel.hit(rayOf(ray));
    return { ...hand, grip, ray, pointed: met?.press, distance: met?.distance };
  }

  #act(hands: readonly Near[], now: number, seconds: number): void {
    this.#fingertips.follow(hands, now);
    for (const hand of hands) {
      const { source } = hand, before = this.#before.get(source) ?? (isMomentary(source) ? NOTHING : hand);
      const pulled = hand.trigger && !before.trigger, squeezed = hand.squeeze && !before.squeeze;
      if (pulled && hand.pointed) this.#press(hand.pointed, source);
      else if (pulled && hand.tip && registration.next.peek()) void this.#touch(this.#fingertips.touched(hand, now));
      else if (pulled || (squeezed && hands.filter(({ squeeze }) => squeeze).length === 1)) this.#handle.take(source, hand.grip, hand.ray);
      if (hand.back && !before.back) proposal.reject();
      const [right] = hand.stick;
      if (Math.abs(right) > DEAD_STICK && !this.#walks(source)) proposal.scrub((right * seconds) / SCRUB_SECONDS);
    }
    this.#before = new Map(hands.map(({ source, trigger, squeeze, back }) => [source, { trigger, squeeze, back }]));
    const taker = hands.find(({ source }) => source === this.#handle.source);
    if (taker && (taker.trigger || taker.squeeze)) this.#handle.drag(taker.grip, taker.ray, now);
    else this.#handle.drop();
    const holder = hands.find(({ source }) => source === this.#holder);
    if (holder?.trigger && holder.ray) proposal.hold();
    else this.#unhold();
  }

  /** Has two hands that squeeze, and don't hold the ball, take the cell to another size and place. */
  #resize(hands: readonly Hand[]): void {
    const grips = hands.flatMap(({ squeeze, grip }) => (squeeze && grip ? [grip] : []));
    const world_t_room = this.#stretch.follow(this.#handle.source ? [] : grips, this.#rig.matrix);
    if (world_t_room) this.#lay(world_t_room);
  }

  /** Takes the cell to another size, by which the chosen robot stays where it is seen. */
  #step(press: "smaller" | "larger" | "life"): void {
    const meters = press === "life" ? 1 : stepFrom(scale.peek(), press === "larger");
    if (this.#handle.source || meters === scale.peek()) return;
    if (meters === 1 && this.mode === "immersive-ar" && this.#lifeSize) return this.#lay(this.#lifeSize);
    const base = new Vector3().setFromMatrixPosition(this.view.solids.places.get(chosen.peek()) ?? new Matrix4());
    const world_t_room = resized(this.#rig.matrix, meters, base.clone().applyMatrix4(this.#rig.matrix.clone().invert()), base);
    // In life size both floors are one.
    if (meters === 1) world_t_room.elements[14] = this.#floor;
    this.#lay(world_t_room);
  }

  /** Lays the room into the world. */
  #lay(world_t_room: Matrix4): void {
    if (scale.peek() === 1) this.#lifeSize = this.#rig.matrix.clone();
    this.#rig.matrix.copy(world_t_room);
    this.#rig.updateMatrixWorld(true);
    // Life size to a part in 1e9 is life size.
    scale.value = Math.abs(scaleOf(world_t_room) - 1) < 1e-9 ? 1 : scaleOf(world_t_room);
    this.#handle.scale = scale.peek();
  }

  #walks({ handedness }: XRInputSource): boolean {
    return this.mode === "immersive-vr" && handedness === "left";
  }

  /** Goes where the left stick is pushed to, as the head looks, and turns with the other one, as long as that looks at no way. */
  #walk(hands: readonly Near[], room_t_head: Matrix4, seconds: number): void {
    const [walker, turner] = [true, false].map((walks) => hands.find(({ source }) => this.#walks(source) === walks)?.stick ?? [0, 0]);
    const leaned = Math.abs(turner[0]) > TURN_STICK && !proposal.way.peek() ? Math.sign(turner[0]) : 0;
    const turn = this.#leaned ? 0 : -leaned * TURN;
    this.#leaned = leaned;
    const [right, ahead] = walker.map((value) => (Math.abs(value) > DEAD_STICK ? value * settings.peek().speed * seconds * scale.peek() : 0));
    if (turn || right || ahead) this.#rig.matrix.copy(walked(this.#rig.matrix, room_t_head, turn, right, ahead));
  }

  #press(press: Press, source: XRInputSource): void {
    if (press === "hold") this.#holder ??= source;
    else if (press === "stop") void stop();
    else if (press === "reject") proposal.reject();
    else if (press === "undo") void proposal.undo();
    else if (press === "teach") void teach(chosen.peek());
    else if (press === "lead") teleop.toggle();
    else if (press === "register") registration.begin();
    else if (press === "smaller" || press === "larger" || press === "life") this.#step(press);
    else this.leave();
  }

  /** Lays the room into the world as it was touched; undefined for a finger that was not still. */
  async #touch(tip: Vector3 | undefined): Promise<void> {
    if (!tip) return registration.askForStill();
    const world_t_room = await registration.touch(tip);
    if (!world_t_room) return;
    this.#lay(world_t_room);
    if (this.mode === "immersive-ar") this.#anchor.keep(world_t_room, tip);
  }

  #unhold(): void {
    if (!this.#holder) return;
    this.#holder = undefined;
    proposal.letGo();
  }

  /** Has whatever is held let go, as when hands aren't seen any more. */
  #letGo(): void {
    this.#unhold();
    this.#handle.drop();
  }
}
