"""PyBullet and MuJoCo on the scene of `ray_cell`: the other engines that robot simulators cast rays with."""

# pyright: reportAttributeAccessIssue=false, reportCallIssue=false, reportMissingImports=false
# Neither engine tells the types of what it holds.
from __future__ import annotations

import mujoco
import numpy as np
import pybullet
from numpy.typing import NDArray

from benchmarks.ray_cell import RayCell

Floats = NDArray[np.float64]
_AT_ONCE = 16_000
"""PyBullet takes 16,384 rays in a call."""


class Bullet:
    """Holds a PyBullet world of a cell until it is closed."""

    def __init__(self, cell: RayCell) -> None:
        """Make a body of each element, its triangles as they are."""
        self._client = client = pybullet.connect(pybullet.DIRECT)
        self._bodies = []
        for shape, pose in zip(cell.shapes, cell.world_t_element, strict=True):
            form = pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                vertices=shape.vertices.tolist(),
                indices=shape.triangles.ravel().tolist(),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=client,
            )
            body = pybullet.createMultiBody(0, form, physicsClientId=client)
            self._bodies.append(body)
            self._place(body, pose)

    def move(self, poses: Floats, first: int) -> None:
        """Place the elements from the row `first` on anew."""
        for body, pose in zip(self._bodies[first:], poses[first:], strict=True):
            self._place(body, pose)
        pybullet.performCollisionDetection(physicsClientId=self._client)

    def cast(self, origin: Floats, directions: Floats, max_range: float) -> Floats:
        """Return distances (n,), inf where nothing is hit."""
        parts = []
        for start in range(0, len(directions), _AT_ONCE):
            ends = origin + max_range * directions[start : start + _AT_ONCE]
            begins = np.broadcast_to(origin, ends.shape).tolist()
            hits = pybullet.rayTestBatch(begins, ends.tolist(), numThreads=1, physicsClientId=self._client)
            parts.append([max_range * hit[2] if hit[0] >= 0 else np.inf for hit in hits])
        return np.concatenate(parts)

    def close(self) -> None:
        """Free the world."""
        pybullet.disconnect(self._client)

    def _place(self, body: int, pose: Floats) -> None:
        pybullet.resetBasePositionAndOrientation(
            body, pose[:3, 3].tolist(), _quaternion(pose)[[1, 2, 3, 0]].tolist(), physicsClientId=self._client
        )


class Mujoco:
    """Holds a MuJoCo model of a cell."""

    def __init__(self, cell: RayCell) -> None:
        """Make a geom of each element; its rays meet the triangles themselves, not their hull."""
        spec = mujoco.MjSpec()
        for place, (shape, pose) in enumerate(zip(cell.shapes, cell.world_t_element, strict=True)):
            mesh = spec.add_mesh(name=f"shape{place}")
            mesh.uservert, mesh.userface = shape.vertices.ravel().tolist(), shape.triangles.ravel().tolist()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
            if place >= cell.first_link:
                body = spec.worldbody.add_body(name=f"link{place}", mocap=True)
                body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"shape{place}")
            else:
                spec.worldbody.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_MESH,
                    meshname=f"shape{place}",
                    pos=pose[:3, 3].tolist(),
                    quat=_quaternion(pose).tolist(),
                )
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)

    def move(self, poses: Floats, first: int) -> None:
        """Place the elements from the row `first` on anew."""
        for place, pose in enumerate(poses[first:]):
            self._data.mocap_pos[place], self._data.mocap_quat[place] = pose[:3, 3], _quaternion(pose)
        mujoco.mj_kinematics(self._model, self._data)

    def cast(self, origin: Floats, directions: Floats, max_range: float) -> Floats:
        """Return distances (n,), inf where nothing is hit; normals are found too."""
        count = len(directions)
        geoms, distances, normals = np.zeros(count, np.int32), np.zeros(count), np.zeros(3 * count)
        mujoco.mj_multiRay(
            *(self._model, self._data, origin, directions.ravel(), None, 1, -1, geoms, distances, normals),
            *(count, max_range),
        )
        return np.where(distances < 0.0, np.inf, distances)


def _quaternion(pose: Floats) -> Floats:
    """Return the rotation as w, x, y, z."""
    result = np.zeros(4)
    mujoco.mju_mat2Quat(result, np.ascontiguousarray(pose[:3, :3]).ravel())
    return result
