// Heads of people who stand in the cell with headsets, as all others see them: in one drawing.
import { effect } from "@preact/signals";
import { BoxGeometry, Color, Float32BufferAttribute, InstancedMesh, MeshStandardMaterial, SphereGeometry, Vector3, type BufferGeometry } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { viewers } from "../kernel/viewers";
import { matrixOf } from "./poses";
import { companion } from "./spectator";
import type { Viewport } from "./viewport";

/** As many as the kernel tells of. */
const MOST = 64;
const SKIN = 0x19b8a6, VISOR = 0x15191f;
const RADIUS = 0.1;
/** The headset before the face, m. */
const VISOR_SIZE = [0.17, 0.09, 0.07] as const, VISOR_AHEAD = 0.075;

export function drawHeads(view: Viewport): void {
  const shape = mergeGeometries([
    painted(new SphereGeometry(RADIUS, 20, 14).scale(0.85, 1.15, 1), SKIN),
    painted(new BoxGeometry(...VISOR_SIZE).translate(0, 0.01, -VISOR_AHEAD), VISOR),
  ]);
  const heads = new InstancedMesh(shape, new MeshStandardMaterial({ vertexColors: true, roughness: 0.7 }), MOST);
  heads.frustumCulled = false;
  view.stage.scene.add(heads);
  effect(() => {
    const all = viewers.value.filter(({ id }) => id !== companion.value).slice(0, MOST);
    all.forEach(({ worldTHead, scale }, place) => {
      heads.setMatrixAt(place, matrixOf(worldTHead).scale(new Vector3().setScalar(scale)));
    });
    heads.count = all.length;
    heads.visible = all.length > 0;
    heads.instanceMatrix.needsUpdate = true;
    view.invalidate();
  });
}

function painted(geometry: BufferGeometry, color: number): BufferGeometry {
  const { count } = geometry.getAttribute("position"), { r, g, b } = new Color(color);
  return geometry.setAttribute("color", new Float32BufferAttribute(Array.from({ length: count }, () => [r, g, b]).flat(), 3));
}
