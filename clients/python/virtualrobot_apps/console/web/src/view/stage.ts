// The stage: renderer, lights, floor grid and background, in both themes.
import * as THREE from "three";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";

type Theme = "dark" | "light";

const QUALITY = new URLSearchParams(location.search).get("quality") ?? "high";

const SKY = {
  dark: ["#39434f", "#232a33", "#171c22"],
  light: ["#f7f9fb", "#e6ebf0", "#cfd7df"],
};
const INK = { dark: 0xb8c6d6, light: 0x3a4652 };

const GRID_VERTEX = `
  varying vec3 place;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    place = world.xyz;
    gl_Position = projectionMatrix * viewMatrix * world;
  }`;

// Lines every 0.25 m and 1 m that fade with the distance, red and green along the axes x and y.
const GRID_FRAGMENT = `
  uniform vec3 ink;
  varying vec3 place;
  float line(vec2 at, float pitch) {
    vec2 cell = at / pitch;
    vec2 distance = abs(fract(cell - 0.5) - 0.5) / fwidth(cell);
    return 1.0 - min(min(distance.x, distance.y), 1.0);
  }
  void main() {
    float fade = 1.0 - smoothstep(4.0, 14.0, length(place.xy));
    float alpha = max(line(place.xy, 0.25) * 0.10, line(place.xy, 1.0) * 0.28) * fade;
    vec3 color = ink;
    vec2 width = fwidth(place.xy);
    if (abs(place.y) < width.y * 0.9) { color = vec3(0.86, 0.27, 0.30); alpha = max(alpha, 0.5 * fade); }
    if (abs(place.x) < width.x * 0.9) { color = vec3(0.36, 0.72, 0.36); alpha = max(alpha, 0.5 * fade); }
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(color, alpha);
    #include <colorspace_fragment>
  }`;

export class Stage {
  readonly scene = new THREE.Scene();
  readonly renderer: THREE.WebGLRenderer;
  readonly grid: THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial>;
  #sun = new THREE.DirectionalLight(0xffffff, 1.7);
  #theme: Theme = "dark";
  /** What is hidden in a room, and shown again after it. */
  #left?: { background: THREE.Scene["background"]; grid: boolean };

  constructor() {
    this.renderer = new THREE.WebGLRenderer({ antialias: QUALITY === "high", stencil: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.shadowMap.enabled = QUALITY === "high";
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.#light();
    this.grid = floor();
    this.scene.add(this.grid);
  }

  setTheme(theme: Theme): void {
    this.#theme = theme;
    if (this.#left) this.#left.background = sky(SKY[theme]);
    else this.scene.background = sky(SKY[theme]);
    this.grid.material.uniforms.ink.value.set(INK[theme]);
  }

  /** Shows the cell in a room: with an even sky, or in the real one, which needs neither sky nor floor; and without shadows, which are slow. */
  enter(isReal: boolean): void {
    this.#left = { background: this.scene.background, grid: this.grid.visible };
    this.scene.background = isReal ? null : new THREE.Color(SKY[this.#theme][1]);
    this.grid.visible &&= !isReal;
    this.#sun.castShadow = false;
    this.renderer.xr.enabled = true;
  }

  /** Shows it on the page again. */
  leave(): void {
    this.renderer.xr.enabled = false;
    this.#sun.castShadow = true;
    if (!this.#left) return;
    this.scene.background = this.#left.background;
    this.grid.visible = this.#left.grid;
    this.#left = undefined;
  }

  #light(): void {
    const sky = new THREE.HemisphereLight(0xdfe9f5, 0x39414c, QUALITY === "high" ? 0.35 : 1.6);
    this.scene.add(sky);
    if (QUALITY === "high") this.#surround();
    const sun = this.#sun;
    sun.position.set(2.5, -3.5, 6);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -4, right: 4, top: 4, bottom: -4, near: 0.5, far: 16 });
    sun.shadow.bias = -0.0004;
    sun.shadow.normalBias = 0.02;
    sun.shadow.radius = 4;
    this.scene.add(sun, sun.target);
  }

  /** Lets surfaces mirror a room, as metal does; slow without a graphics card. */
  #surround(): void {
    const generator = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = generator.fromScene(new RoomEnvironment(), 0.04).texture;
    // The room's up is y, the world's z.
    this.scene.environmentRotation.set(Math.PI / 2, 0, 0);
    this.scene.environmentIntensity = 0.55;
  }
}

function floor(): THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial> {
  const material = new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    side: THREE.DoubleSide,
    uniforms: { ink: { value: new THREE.Color() } },
    vertexShader: GRID_VERTEX,
    fragmentShader: GRID_FRAGMENT,
  });
  const grid = new THREE.Mesh(new THREE.PlaneGeometry(60, 60), material);
  grid.position.z = 0.0005;
  grid.renderOrder = -1;
  return grid;
}

function sky(colors: readonly string[]): THREE.Texture {
  const canvas = document.createElement("canvas");
  canvas.width = 4;
  canvas.height = 256;
  const pen = canvas.getContext("2d")!;
  const gradient = pen.createLinearGradient(0, 0, 0, canvas.height);
  [0, 0.55, 1].forEach((stop, place) => gradient.addColorStop(stop, colors[place]));
  pen.fillStyle = gradient;
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}
