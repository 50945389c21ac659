"""Cameras of other engines on the scene of `ray_cell`: PyBullet's software renderer, and VTK without screen or GPU."""

# Neither engine tells the types of what it holds, and VTK is of the extra `bench`.
# pyright: reportAttributeAccessIssue=false, reportCallIssue=false, reportMissingImports=false
from __future__ import annotations

import numpy as np
import pybullet
import vtk
from numpy.typing import NDArray
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

from benchmarks.ray_cell import MAX_RANGE, SENSOR, RayCell

WIDTH, HEIGHT = 640, 480
FIELD = 1.0
"""Between the upper and the lower edge, in radians."""
TARGET = np.array([0.0, 0.0, 0.6])
NEAR = 0.05


class BulletCamera:
    """Takes pictures with PyBullet's TinyRenderer: colour with one light and its shadow, depth and segmentation."""

    def __init__(self, cell: RayCell, client: int) -> None:
        """Make visible bodies of all elements in the PyBullet world `client`."""
        self._client = client
        for shape, pose in zip(cell.shapes, cell.world_t_element, strict=True):
            corners = shape.vertices.tolist()
            look = pybullet.createVisualShape(
                pybullet.GEOM_MESH,
                vertices=corners,
                indices=shape.triangles.ravel().tolist(),
                normals=_normals(shape.vertices, shape.triangles).tolist(),
                physicsClientId=client,
            )
            quaternion = pybullet.getQuaternionFromEuler(_euler(pose))
            pybullet.createMultiBody(0, -1, look, pose[:3, 3].tolist(), quaternion, physicsClientId=client)
        self._view = pybullet.computeViewMatrix(SENSOR.tolist(), TARGET.tolist(), [0, 0, 1])
        self._projection = pybullet.computeProjectionMatrixFOV(np.degrees(FIELD), WIDTH / HEIGHT, NEAR, MAX_RANGE)

    def take(self, shadow: bool) -> NDArray[np.uint8]:
        """Return red, green, blue, alpha (height, width, 4)."""
        picture = pybullet.getCameraImage(
            WIDTH,
            HEIGHT,
            self._view,
            self._projection,
            shadow=shadow,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        return np.reshape(picture[2], (HEIGHT, WIDTH, 4))


class VtkCamera:
    """Takes pictures with VTK: colour with a head light, and depth."""

    _COLORS, _DEPTHS = 3, 5

    def __init__(self, cell: RayCell) -> None:
        """Make an actor of each element."""
        self._renderer = vtk.vtkRenderer()
        for shape, pose in zip(cell.shapes, cell.world_t_element, strict=True):
            points, polygons = vtk.vtkPoints(), vtk.vtkCellArray()
            points.SetData(numpy_to_vtk(shape.vertices, deep=True))
            rows = np.column_stack([np.full(len(shape.triangles), 3), shape.triangles]).astype(np.int64).ravel()
            polygons.ImportLegacyFormat(numpy_to_vtkIdTypeArray(rows, deep=True))
            data = vtk.vtkPolyData()
            data.SetPoints(points)
            data.SetPolys(polygons)
            mapper = vtk.vtkPolyDataMapper()
            mapper.SetInputData(data)
            actor = vtk.vtkActor()
            actor.SetMapper(mapper)
            matrix = vtk.vtkMatrix4x4()
            matrix.DeepCopy(pose.ravel().tolist())
            actor.SetUserMatrix(matrix)
            self._renderer.AddActor(actor)
        self._window = vtk.vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self._window.SetSize(WIDTH, HEIGHT)
        self._window.AddRenderer(self._renderer)
        camera = self._renderer.GetActiveCamera()
        camera.SetPosition(*SENSOR)
        camera.SetFocalPoint(*TARGET)
        camera.SetViewUp(0, 0, 1)
        camera.SetViewAngle(np.degrees(FIELD))
        camera.SetClippingRange(NEAR, MAX_RANGE)

    def take(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Return colours (height, width, 3) and depths in the buffer's own scale, both from below upwards."""
        self._renderer.Modified()
        self._window.Render()
        pictures = [self._read(kind) for kind in (self._COLORS, self._DEPTHS)]
        return pictures[0].reshape(HEIGHT, WIDTH, 3), pictures[1].reshape(HEIGHT, WIDTH)

    def _read(self, kind: int) -> NDArray:
        filter = vtk.vtkWindowToImageFilter()
        filter.SetInput(self._window)
        filter.SetInputBufferType(kind)
        filter.ShouldRerenderOff()
        filter.Update()
        return vtk_to_numpy(filter.GetOutput().GetPointData().GetScalars())


def _normals(vertices: NDArray[np.float32], triangles: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return a unit normal of each vertex (v, 3): TinyRenderer wants them."""
    corners = vertices[triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros((len(vertices), 3))
    for column in range(3):
        np.add.at(normals, triangles[:, column], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def _euler(pose: NDArray[np.float64]) -> list[float]:
    """Return roll, pitch, yaw of a pose."""
    r = pose[:3, :3]
    return [np.arctan2(r[2, 1], r[2, 2]), np.arcsin(np.clip(-r[2, 0], -1.0, 1.0)), np.arctan2(r[1, 0], r[0, 0])]
