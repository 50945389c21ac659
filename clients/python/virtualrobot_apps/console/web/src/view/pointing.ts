// Where the pointer is in the cell.
import * as THREE from "three";
import type { Viewport } from "./viewport";

const FLOOR = new THREE.Plane(new THREE.Vector3(0, 0, 1), 0);
const MOST_METERS = 50;
const STEP_METERS = 0.01;

export interface Surface {
  /** In the world's frame, on a raster of 10 mm on the floor and on what lies level. */
  point: THREE.Vector3;
  level: boolean;
}

export interface Pointer {
  clientX: number;
  clientY: number;
}

/** Returns the ray through the pointer. */
export function pointerRay({ canvas, observer }: Viewport, { clientX, clientY }: Pointer): THREE.Raycaster {
  const area = canvas.getBoundingClientRect();
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2((2 * (clientX - area.left)) / area.width - 1, 1 - (2 * (clientY - area.top)) / area.height), observer.camera);
  return ray;
}

/** Returns where the ray through the pointer meets the cell or else the floor; undefined where it meets neither. */
export function surfaceAt(viewport: Viewport, pointer: Pointer): Surface | undefined {
  const ray = pointerRay(viewport, pointer);
  const [nearest] = hits(viewport.solids, ray).sort((one, other) => one.distance - other.distance);
  const point = nearest?.point ?? ray.ray.intersectPlane(FLOOR, new THREE.Vector3());
  if (!point || point.length() > MOST_METERS) return undefined;
  const normal = nearest?.face && nearest.face.normal.clone().transformDirection(nearest.object.matrixWorld);
  const level = !normal || Math.abs(normal.z) > 0.99;
  return { point: level ? new THREE.Vector3(snapped(point.x), snapped(point.y), Math.abs(point.z) < 1e-4 ? 0 : point.z) : point, level };
}

function snapped(meters: number): number {
  return Math.round(meters / STEP_METERS) * STEP_METERS;
}

function hits({ pieces, places }: Viewport["solids"], ray: THREE.Raycaster): THREE.Intersection[] {
  const found: THREE.Intersection[] = [];
  for (const [name, some] of pieces) {
    const place = places.get(name);
    if (!place) continue;
    for (const { geometry, local } of some) {
      const mesh = new THREE.Mesh(geometry, SURFACE);
      mesh.matrixWorld.multiplyMatrices(place, local);
      mesh.raycast(ray, found);
    }
  }
  return found;
}

const SURFACE = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide });
