// Plays the run that stands in the page: an animated scene, its time to scrub, the node that is pointed at.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { Stage } from "../view/stage";
import { LOOK, SPEEDS } from "./look";

const STEP_SECONDS = 0.1;

/** Four corners, drawn: few fonts have a letter for them. */
const CORNERS =
  '<svg viewBox="0 0 24 24" width="15" height="15" fill="none" stroke="currentColor" stroke-width="2" aria-hidden="true"><path d="M8 3H3v5m18 0V3h-5M3 16v5h5m8 0h5v-5"/></svg>';

function bytesOf(id: string): ArrayBuffer {
  const text = atob(document.getElementById(id)!.textContent!);
  return Uint8Array.from(text, (letter) => letter.charCodeAt(0)).buffer;
}

class Player {
  readonly #stage = new Stage();
  readonly #camera = new THREE.PerspectiveCamera(40, 1, 0.01, 200);
  readonly #controls = new OrbitControls(this.#camera, this.#stage.renderer.domElement);
  readonly #world = new THREE.Group();
  readonly #mixer = new THREE.AnimationMixer(this.#world);
  readonly #actions: THREE.AnimationAction[] = [];
  readonly #clock = new THREE.Timer();
  readonly #play = button("Play or pause (Space)");
  readonly #slider = document.createElement("input");
  readonly #time = document.createElement("output");
  readonly #name = document.createElement("output");
  #duration = 0;
  #now = 0;
  #speed = 1;
  #playing = false;

  constructor(model: { scene: THREE.Group; animations: THREE.AnimationClip[] }) {
    // The file has y upwards, the stage z.
    this.#world.rotation.x = Math.PI / 2;
    this.#world.add(model.scene);
    this.#stage.scene.add(this.#world);
    this.#camera.up.set(0, 0, 1);
    this.#controls.enableDamping = true;
    model.scene.traverse((one) => {
      if (one instanceof THREE.Mesh) one.castShadow = one.receiveShadow = true;
    });
    this.#duration = Number(model.scene.userData.duration) || 0;
    for (const clip of model.animations) {
      this.#duration = Math.max(this.#duration, clip.duration);
      const action = this.#mixer.clipAction(clip, model.scene);
      action.setLoop(THREE.LoopOnce, 1);
      action.clampWhenFinished = true;
      action.play();
      this.#actions.push(action);
    }
    this.#build();
    this.seek(0);
    this.frame();
    this.play(this.#duration > 0);
    this.#stage.renderer.setAnimationLoop(() => this.#draw());
  }

  play(playing: boolean): void {
    if (playing && this.#now >= this.#duration) this.seek(0);
    this.#playing = playing && this.#duration > 0;
    this.#play.textContent = this.#playing ? "❚❚" : "▶";
    document.body.dataset.playing = String(this.#playing);
  }

  seek(seconds: number): void {
    this.#now = Math.min(Math.max(seconds, 0), this.#duration);
    // An action that has come to its end stays there unless it is begun again.
    for (const action of this.#actions) action.paused = false;
    this.#mixer.setTime(this.#now);
    this.#slider.value = String(this.#now);
    this.#slider.setAttribute("aria-valuetext", `${this.#now.toFixed(2)} s`);
    this.#time.textContent = `${this.#now.toFixed(2)} / ${this.#duration.toFixed(2)} s`;
  }

  frame(): void {
    this.#world.updateMatrixWorld(true);
    const box = new THREE.Box3();
    this.#world.traverseVisible((one) => {
      if (one instanceof THREE.Mesh && one.matrixWorld.determinant() !== 0) box.expandByObject(one);
    });
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, 0), new THREE.Vector3(1, 1, 1));
    const ball = box.getBoundingSphere(new THREE.Sphere());
    const away = (1.15 * ball.radius) / Math.sin((this.#camera.fov * Math.PI) / 360);
    this.#controls.target.copy(ball.center);
    this.#camera.position.copy(ball.center).add(new THREE.Vector3(0.62, -0.66, 0.42).normalize().multiplyScalar(away));
  }

  #build(): void {
    const canvas = this.#stage.renderer.domElement;
    const style = document.createElement("style");
    style.textContent = LOOK;
    document.head.append(style);
    canvas.setAttribute("aria-label", "3D view of the run");
    const bar = document.createElement("div");
    bar.className = "bar";
    Object.assign(this.#slider, { type: "range", min: "0", max: String(this.#duration), step: "any", title: "Time (s)" });
    this.#slider.setAttribute("aria-label", "Time (s)");
    const speed = document.createElement("select");
    speed.title = "Speed";
    speed.append(...SPEEDS.map((one) => new Option(`${one}×`, String(one), one === 1, one === 1)));
    const whole = button("Look at all of it (F)");
    whole.innerHTML = CORNERS;
    this.#name.className = "name";
    bar.append(this.#play, this.#slider, this.#time, speed, whole);
    document.body.append(canvas, this.#name, bar);
    this.#play.onclick = () => this.play(!this.#playing);
    this.#slider.oninput = () => {
      this.play(false);
      this.seek(Number(this.#slider.value));
    };
    speed.onchange = () => (this.#speed = Number(speed.value));
    whole.onclick = () => this.frame();
    canvas.onpointermove = (event) => this.#point(event);
    addEventListener("resize", () => this.#resize());
    addEventListener("keydown", (event) => this.#key(event));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const paint = () => this.#stage.setTheme(dark.matches ? "dark" : "light");
    dark.onchange = paint;
    paint();
    this.#resize();
  }

  #key(event: KeyboardEvent): void {
    const steps: Record<string, () => void> = {
      " ": () => this.play(!this.#playing),
      ArrowRight: () => this.seek(this.#now + STEP_SECONDS),
      ArrowLeft: () => this.seek(this.#now - STEP_SECONDS),
      Home: () => this.seek(0),
      End: () => this.seek(this.#duration),
      f: () => this.frame(),
    };
    const step = event.ctrlKey || event.metaKey || event.target instanceof HTMLSelectElement ? undefined : steps[event.key];
    if (!step) return;
    event.preventDefault();
    step();
  }

  /** Tells the name of the node that the pointer is at. */
  #point(event: PointerEvent): void {
    const at = new THREE.Vector2((2 * event.offsetX) / innerWidth - 1, 1 - (2 * event.offsetY) / innerHeight);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.#camera);
    const hit = event.buttons ? undefined : ray.intersectObject(this.#world, true)[0];
    let node: THREE.Object3D | null = hit?.object ?? null;
    while (node && !node.userData.name) node = node.parent;
    this.#name.textContent = (node?.userData.name as string | undefined) ?? "";
    this.#name.style.translate = `${event.clientX + 14}px ${event.clientY + 10}px`;
  }

  #resize(): void {
    this.#stage.renderer.setSize(innerWidth, innerHeight);
    this.#camera.aspect = innerWidth / innerHeight;
    this.#camera.updateProjectionMatrix();
  }

  #draw(): void {
    this.#clock.update();
    if (this.#playing) {
      this.seek(this.#now + this.#speed * this.#clock.getDelta());
      if (this.#now >= this.#duration) this.play(false);
    }
    this.#controls.update();
    this.#stage.renderer.render(this.#stage.scene, this.#camera);
    this.#stage.renderer.domElement.dataset.drawn = this.#now.toFixed(2);
  }
}

function button(title: string): HTMLButtonElement {
  const made = document.createElement("button");
  made.title = title;
  made.setAttribute("aria-label", title);
  return made;
}

new GLTFLoader().parse(
  bytesOf("run"),
  "",
  (model) => new Player(model),
  (error) => (document.body.textContent = `This run can't be shown: ${error instanceof Error ? error.message : String(error)}`),
);
