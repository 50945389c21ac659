// Copies of what nodes look like: silhouettes of what is selected and marked, and robots shown where they are not.
import * as THREE from "three";
import type { Piece } from "./figures";

type Pieces = ReadonlyMap<string, readonly Piece[]>;
type Places = ReadonlyMap<string, THREE.Matrix4>;

const RIM_PIXELS = 4.2;
const SAME = 1e-4;

const RIM_VERTEX = `
  uniform vec2 pixel;
  void main() {
    vec4 place = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    vec3 outwards = normalize(mat3(projectionMatrix) * normalMatrix * normal);
    place.xy += normalize(outwards.xy + 1e-6) * pixel * place.w;
    gl_Position = place;
  }`;
const RIM_FRAGMENT = `
  uniform vec3 color;
  void main() {
    gl_FragColor = vec4(color, 1.0);
    #include <colorspace_fragment>
  }`;

/** Silhouette of nodes: they mark the stencil, then swollen copies are drawn where it is not marked. */
export class Silhouette {
  readonly group = new THREE.Group();
  #mark = new THREE.MeshBasicMaterial({
    colorWrite: false, depthWrite: false, depthTest: false,
    stencilWrite: true, stencilRef: 1, stencilFunc: THREE.AlwaysStencilFunc, stencilZPass: THREE.ReplaceStencilOp,
  });
  #rim: THREE.ShaderMaterial;

  constructor(color: number) {
    this.#rim = new THREE.ShaderMaterial({
      depthTest: false, depthWrite: false,
      stencilWrite: true, stencilRef: 1, stencilFunc: THREE.NotEqualStencilFunc,
      uniforms: { color: { value: new THREE.Color(color) }, pixel: { value: new THREE.Vector2() } },
      vertexShader: RIM_VERTEX,
      fragmentShader: RIM_FRAGMENT,
    });
  }

  show(names: readonly string[], pieces: Pieces, places: Places): void {
    this.group.clear();
    for (const name of names) {
      for (const piece of pieces.get(name) ?? []) {
        this.group.add(copy(piece, name, this.#mark, 900), copy(piece, name, this.#rim, 901));
      }
    }
    this.place(places);
  }

  place(places: Places): void {
    for (const object of this.group.children) {
      const pose = places.get(object.userData.node as string);
      if (!pose) continue;
      object.matrix.multiplyMatrices(pose, object.userData.local as THREE.Matrix4);
      object.matrixWorldNeedsUpdate = true;
    }
  }

  setSize(width: number, height: number): void {
    this.#rim.uniforms.pixel.value.set(RIM_PIXELS / width, RIM_PIXELS / height);
  }
}

/** Translucent copy of nodes at other places; depth first and colour after it, so that no faces inside are seen. */
export class Ghost {
  readonly group = new THREE.Group();
  /** Whether it is asked for where it stands. */
  isAwaited = false;
  /** Where the nodes are shown; another map whenever they are shown elsewhere. */
  there: Places = new Map();
  #first = new THREE.MeshBasicMaterial({ colorWrite: false, transparent: true });
  #second: THREE.MeshStandardMaterial;

  constructor(color: number, opacity = 0.45) {
    const glow = { emissive: color, emissiveIntensity: 0.25 };
    this.#second = new THREE.MeshStandardMaterial({ color, transparent: true, opacity, roughness: 0.5, depthWrite: false, ...glow });
  }

  /** Shows nodes at `there`; those that are there anyhow are left out. */
  show(there: Places, pieces: Pieces, places: Places): void {
    this.there = there;
    this.group.clear();
    for (const [name, pose] of there) {
      const now = places.get(name);
      if (now?.elements.every((value, place) => Math.abs(value - pose.elements[place]) < SAME)) continue;
      for (const piece of pieces.get(name) ?? []) {
        for (const object of [copy(piece, name, this.#first, 800), copy(piece, name, this.#second, 801)]) {
          object.matrix.multiplyMatrices(pose, piece.local);
          object.matrixWorldNeedsUpdate = true;
          this.group.add(object);
        }
      }
    }
  }

  /** Shows the same nodes at the same places, as they look now. */
  renew(pieces: Pieces, places: Places): void {
    this.show(this.there, pieces, places);
  }

  hide(): void {
    this.isAwaited = false;
    this.there = new Map();
    this.group.clear();
  }
}

function copy({ geometry, local }: Piece, node: string, material: THREE.Material, order: number): THREE.Mesh {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.matrixAutoUpdate = false;
  mesh.frustumCulled = false;
  mesh.renderOrder = order;
  mesh.userData = { node, local };
  return mesh;
}
