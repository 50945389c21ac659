// The panel in the room: what is proposed, in words and color, and buttons that are pressed by pointing at them.
import { CanvasTexture, DoubleSide, Mesh, MeshBasicMaterial, PlaneGeometry, Raycaster, SRGBColorSpace, Vector3, type Matrix4, type Ray } from "three";
import { goal } from "../kernel/goal";
import { stopping } from "../kernel/stop";
import { chosen, states } from "../kernel/world";
import { fixed, positionOf } from "../parts/numbers";
import { beforeHead } from "./rig";
import { cssOf, look } from "./looks";
import { proposal, type Phase } from "./proposal";
import { scale, sizeWords } from "./scale";
import { leads } from "./teleop";

export type Press = "hold" | "stop" | "reject" | "undo" | "teach" | "lead" | "register" | "leave" | "smaller" | "life" | "larger";

/** Right of, ahead of and above the head, m. */
const PLACE = [0.35, 0.8, -0.25] as const;
/** A person who has gone so far away (m) takes it along. */
const FAR_METERS = 1.6;
const SIZE = { meters: [0.48, 0.35], pixels: [768, 560] } as const;

/** Left, top, width, height in pixels. */
type Area = readonly [number, number, number, number];
const GREY = "#2b333d", GREEN = "#1f7d4e", BLUE = "#2f7fd6";
const BUTTONS: readonly (readonly [press: Press, area: Area, color: string])[] = [
  ["hold", [24, 252, 452, 96], GREY],
  ["stop", [492, 252, 252, 96], "#c9262c"],
  ["reject", [24, 364, 112, 92], GREY],
  ["undo", [145, 364, 112, 92], GREY],
  ["teach", [266, 364, 112, 92], GREY],
  ["lead", [387, 364, 112, 92], GREY],
  ["register", [508, 364, 112, 92], GREY],
  ["leave", [629, 364, 112, 92], GREY],
  ["smaller", [24, 472, 233, 68], GREY],
  ["life", [266, 472, 233, 68], GREY],
  ["larger", [508, 472, 233, 68], GREY],
];
const NAMES: Record<Press, string> = { hold: "Hold to run", stop: "STOP", reject: "Reject", undo: "Undo", teach: "Teach", lead: "Lead", register: "Register", leave: "Leave", smaller: "Smaller", life: "Life size", larger: "Larger" };
const CAN_RUN = new Set<Phase>(["free", "running", "paused"]);
/** Sizes of words (px), the smaller one for those that the larger one has no room for, with the lines that there are and how far apart. */
const WORDS = [{ size: 28, most: 3, apart: 36 }, { size: 22, most: 4, apart: 27 }];
/** Numbers that go on changing, as while a tool is dragged, are written so often (ms): writing takes longer than all else of a picture. */
const NUMBERS_MS = 150;
const FONT = "Inter Variable, sans-serif";

export class Panel {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  #canvas = document.createElement("canvas");
  #texture = new CanvasTexture(this.#canvas);
  #drawn = "";
  #numbers = "";
  #written = 0;
  #ray = new Raycaster();

  constructor() {
    [this.#canvas.width, this.#canvas.height] = SIZE.pixels;
    this.#texture.colorSpace = SRGBColorSpace;
    const material = new MeshBasicMaterial({ map: this.#texture, transparent: true, side: DoubleSide, toneMapped: false });
    this.mesh = new Mesh(new PlaneGeometry(...SIZE.meters), material);
    this.mesh.matrixAutoUpdate = false;
    this.mesh.visible = false;
    this.mesh.renderOrder = 950;
  }

  /** Hangs it before the head at first, and where that has gone far away. */
  place(room_t_head: Matrix4): void {
    const here = new Vector3().setFromMatrixPosition(this.mesh.matrix), head = new Vector3().setFromMatrixPosition(room_t_head);
    if (this.mesh.visible && here.distanceTo(head) < FAR_METERS) return;
    this.mesh.matrix.copy(beforeHead(room_t_head, ...PLACE));
    this.mesh.matrixWorldNeedsUpdate = true;
    this.mesh.visible = true;
  }

  /** Returns which button a ray in the world meets, and how far away (m) the panel is on it; undefined where it misses the panel. */
  hit({ origin, direction }: Ray): { press?: Press; distance: number } | undefined {
    this.#ray.set(origin, direction);
    const [met] = this.#ray.intersectObject(this.mesh, false);
    if (!met?.uv) return undefined;
    const x = met.uv.x * SIZE.pixels[0], y = (1 - met.uv.y) * SIZE.pixels[1];
    const [press] = BUTTONS.find(([, [left, top, width, height]]) => x >= left && x < left + width && y >= top && y < top + height) ?? [];
    return { press, distance: met.distance };
  }

  /** Draws it anew where it says something else; `pointed` are buttons that rays meet, `held` whether the motion is held. */
  draw(pointed: ReadonlySet<Press>, held: boolean): void {
    const { title, words, color: ink } = look.peek();
    const pose = goal.pose.peek() ?? states.peek().get(chosen.peek())?.worldTTcp;
    const where = positionOf(pose).map((value, place) => `${"XYZ"[place]} ${fixed(1000 * value, 0)}`).join("  ");
    const robot = `${chosen.peek()}  ${where} mm`;
    const told = JSON.stringify([title, ink, [...pointed].sort(), held, leads.peek(), stopping.peek(), scale.peek(), proposal.phase.peek()]), numbers = words + robot;
    const now = performance.now(), isDue = numbers !== this.#numbers && now - this.#written > NUMBERS_MS;
    if (told === this.#drawn && !isDue) return;
    this.#drawn = told;
    this.#numbers = numbers;
    this.#written = now;
    const pen = this.#canvas.getContext("2d")!, [width, height] = SIZE.pixels;
    pen.clearRect(0, 0, width, height);
    rounded(pen, [0, 0, width, height], "#15191ff2", 24);
    rounded(pen, [0, 24, 12, 200], cssOf(ink), 6);
    write(pen, title, 36, 64, `600 46px ${FONT}`, cssOf(ink));
    const forms = WORDS.map((form) => ({ ...form, rows: lines(pen, words, width - 60, form.size) }));
    const { size, most, apart, rows } = forms.find(({ rows, most }) => rows.length <= most) ?? forms.at(-1)!;
    const shown = rows.length > most ? [...rows.slice(0, most - 1), `${rows[most - 1]} …`] : rows;
    shown.forEach((line, row) => write(pen, line, 36, 112 + apart * row, `${size}px ${FONT}`, "#e4e9ef"));
    write(pen, robot, 36, 230, `26px ${FONT}`, "#9aa6b4");
    for (const [press, area, color] of BUTTONS) {
      const [left, top, wide, high] = area;
      rounded(pen, area, press === "lead" && leads.peek() ? BLUE : press !== "hold" ? color : held ? BLUE : CAN_RUN.has(proposal.phase.peek()) ? GREEN : GREY, 16);
      if (pointed.has(press)) {
        pen.strokeStyle = "#ffffff";
        pen.lineWidth = 4;
        pen.stroke();
      }
      pen.textAlign = "center";
      const name = press === "stop" && stopping.peek() === "stopped" ? "STOPPED" : press === "life" && scale.peek() !== 1 ? sizeWords(scale.peek()) : NAMES[press];
      write(pen, name, left + wide / 2, top + high / 2 + 12, `600 ${wide < 120 ? 25 : 30}px ${FONT}`, "#ffffff");
      pen.textAlign = "left";
    }
    this.#texture.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.#texture.dispose();
  }
}

function rounded(pen: CanvasRenderingContext2D, area: Area, color: string, radius: number): void {
  pen.beginPath();
  pen.roundRect(...area, radius);
  pen.fillStyle = color;
  pen.fill();
}

function write(pen: CanvasRenderingContext2D, text: string, x: number, y: number, font: string, color: string): void {
  pen.font = font;
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}

/** Returns a text in lines that are no wider than that, px. */
function lines(pen: CanvasRenderingContext2D, text: string, width: number, size: number): string[] {
  pen.font = `${size}px ${FONT}`;
  const found: string[] = [];
  for (const word of text.split(" ")) {
    const longer = found.length > 0 ? `${found.at(-1)} ${word}` : word;
    if (found.length > 0 && pen.measureText(longer).width <= width) found[found.length - 1] = longer;
    else found.push(word);
  }
  return found;
}
