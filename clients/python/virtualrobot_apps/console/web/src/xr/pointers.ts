// Where hands are and point at, as the person sees it: a ray of each up to what it meets, and a cube where it takes hold.
import { BoxGeometry, BufferGeometry, Float32BufferAttribute, Group, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, MeshStandardMaterial, Vector3 } from "three";

/** Hands of a person, with one more of a phone's screen. */
const MOST = 4;
const LONG_METERS = 2, CUBE_METERS = 0.02;

export interface Pointer {
  grip?: Matrix4;
  ray?: Matrix4;
  /** How far (m) its ray goes. */
  distance?: number;
}

export class Pointers {
  readonly group = new Group();
  #rays: LineSegments<BufferGeometry, LineBasicMaterial>;
  #cubes = new InstancedMesh(new BoxGeometry(CUBE_METERS, CUBE_METERS, CUBE_METERS), new MeshStandardMaterial({ color: 0xdfe6ee }), MOST);

  constructor() {
    const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(6 * MOST, 3));
    this.#rays = new LineSegments(geometry, new LineBasicMaterial({ color: 0xdfe6ee, transparent: true, opacity: 0.6 }));
    this.#rays.frustumCulled = this.#cubes.frustumCulled = false;
    this.#rays.renderOrder = 960;
    this.group.add(this.#rays, this.#cubes);
  }

  /** Shows these, whose poses are in the world, with so many meters of it for each of the room. */
  show(pointers: readonly Pointer[], scale: number): void {
    const position = this.#rays.geometry.getAttribute("position"), from = new Vector3(), to = new Vector3();
    const rays = pointers.filter(({ ray }) => ray).slice(0, MOST), grips = pointers.flatMap(({ grip }) => grip ?? []).slice(0, MOST);
    rays.forEach(({ ray, distance = LONG_METERS * scale }, place) => {
      from.setFromMatrixPosition(ray!);
      to.set(0, 0, -1).transformDirection(ray!).multiplyScalar(distance).add(from);
      position.setXYZ(2 * place, ...from.toArray()).setXYZ(2 * place + 1, ...to.toArray());
    });
    position.needsUpdate = true;
    this.#rays.geometry.setDrawRange(0, 2 * rays.length);
    grips.forEach((grip, place) => this.#cubes.setMatrixAt(place, grip));
    this.#cubes.count = grips.length;
    this.#cubes.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.#rays.geometry.dispose();
    this.#rays.material.dispose();
    this.#cubes.geometry.dispose();
    this.#cubes.dispose();
  }
}
