// The cell over the picture of this device's own camera, where there is no WebXR, as on iPhones: laid by a printed marker,
// which the console finds in pictures that this page sends, one after the other.
import { signal } from "@preact/signals";
import { Matrix4 } from "three";
import { askConsole } from "../kernel/console_calls";
import { wordsOf } from "../kernel/words";
import { DEGREES, fixed } from "../parts/numbers";
import { followed } from "../view/follower";
import type { Viewport } from "../view/viewport";

/** What the console finds in a picture. */
interface Found {
  /** Rows. */
  world_t_camera: number[];
  error_away: number;
}

/** The camera that the cell is shown over; undefined for none. */
export const overlaid = signal<Overlay | undefined>(undefined);
/** What there is to say of it, or why there is none. */
export const said = signal("");
/** Horizontal field of view of the camera, degrees: browsers don't tell it. */
export const fieldDegrees = signal(65);
/** The node of the world where the sheet is. */
export const sheet = signal("marker");

const PICTURE_WIDTH = 1280;
const QUALITY = 0.85;
const PREFIX = "data:image/jpeg;base64,";

const REFUSED: Record<string, string> = {
  NotAllowedError: "the browser was not allowed to see by the camera: allow it for this page, and press the button again",
  NotFoundError: "this device has no camera",
  NotReadableError: "another program has the camera: end it there",
};

/** Cameras look along their z, with y down; those of the view along -z, with y up. */
const CAMERA_T_EYE = new Matrix4().makeScale(1, -1, -1);

/** Shows the cell over the camera's picture, where the person lets it. */
export async function overlay(view: Viewport): Promise<void> {
  if (overlaid.peek()) return;
  if (!navigator.mediaDevices) {
    said.value = "browsers show a camera only by https, or on the machine itself: `virtualrobot console --listen 0.0.0.0 --own-certificate` has it";
    return;
  }
  try {
    const video = { facingMode: "environment", width: { ideal: PICTURE_WIDTH } };
    overlaid.value = new Overlay(view, await navigator.mediaDevices.getUserMedia({ video, audio: false }));
    said.value = `look at the sheet of ${sheet.peek()}`;
  } catch (error) {
    const { name, message } = error as DOMException;
    said.value = REFUSED[name] ?? message;
  }
}

export class Overlay {
  #video = document.createElement("video");
  #canvas = document.createElement("canvas");
  #isOver = false;

  constructor(private readonly view: Viewport, private readonly stream: MediaStream) {
    this.#video.className = "behind";
    this.#video.muted = this.#video.playsInline = true;
    this.#video.srcObject = stream;
    view.canvas.before(this.#video);
    view.stage.enter(true);
    view.stage.renderer.setClearAlpha(0);
    followed.value = undefined;
    view.invalidate();
    stream.getVideoTracks()[0].addEventListener("ended", () => this.end("the camera has ended"));
    void this.#look();
  }

  /** Shows the cell alone again. */
  end(words = ""): void {
    if (this.#isOver) return;
    this.#isOver = true;
    for (const track of this.stream.getTracks()) track.stop();
    this.#video.remove();
    this.view.stage.renderer.setClearAlpha(1);
    this.view.stage.leave();
    this.view.observer.release();
    this.view.invalidate();
    overlaid.value = undefined;
    said.value = words;
  }

  /** Asks for one picture after the other where the camera is. */
  async #look(): Promise<void> {
    await this.#video.play();
    while (!this.#isOver) {
      await new Promise(requestAnimationFrame);
      if (this.#video.videoWidth === 0) continue;
      try {
        const picture = this.#picture(), field = fieldDegrees.peek() / DEGREES;
        const found = await askConsole<Found>("/registration/pictures", { pictures: [picture], marker: sheet.peek(), field });
        if (this.#isOver) return;
        this.#place(found.world_t_camera, field);
        said.value = `the cell stands by the sheet of ${sheet.peek()}; ${fixed(1000 * found.error_away, 0)} mm off at most, 1.5 m beside it`;
      } catch (error) {
        if (!this.#isOver) said.value = wordsOf(error);
      }
    }
  }

  /** Returns what the camera sees now, JPEG in base64. */
  #picture(): string {
    const { videoWidth, videoHeight } = this.#video;
    const width = Math.min(PICTURE_WIDTH, videoWidth);
    Object.assign(this.#canvas, { width, height: Math.round((width * videoHeight) / videoWidth) });
    this.#canvas.getContext("2d")!.drawImage(this.#video, 0, 0, width, this.#canvas.height);
    return this.#canvas.toDataURL("image/jpeg", QUALITY).slice(PREFIX.length);
  }

  #place(world_t_camera: readonly number[], field: number): void {
    const place = new Matrix4().set(...(world_t_camera as Parameters<Matrix4["set"]>)).multiply(CAMERA_T_EYE);
    const { clientWidth, clientHeight } = this.view.canvas.parentElement!, { videoWidth, videoHeight } = this.#video;
    // The picture covers the view, and what is beyond it is cut off: a pixel of it is so many of the view's.
    const scale = Math.max(clientWidth / videoWidth, clientHeight / videoHeight);
    const focal = (scale * videoWidth) / 2 / Math.tan(field / 2);
    this.view.observer.hold(place, 2 * Math.atan(clientHeight / 2 / focal) * DEGREES);
  }
}
