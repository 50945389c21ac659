"""Looks are made once for all who see, kept while somebody does, and stand in the order of the shapes' triangles."""

from __future__ import annotations

import gc

import numpy as np
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import UpdateNode
from virtualrobot_kernel.world.figures import Mesh

from tests.drawing.cell import Cell


def elements(cell: Cell) -> Elements:
    return elements_of(cell.snapshot, ShapeLibrary(cell.meshes))


def test_what_is_seen_again_is_not_made_again(rng: np.random.Generator) -> None:
    cell, asked = Cell(), []
    cell.load("kuka_iiwa/model.urdf", "iiwa")

    def meshes(mesh: Mesh) -> tuple[Submesh, ...]:
        asked.append(mesh)
        return cell.meshes(mesh)

    library = AppearanceLibrary(meshes)
    first = library.of(elements(cell))
    count = len(asked)
    assert count == 8
    again = library.of(elements(cell))
    assert again.surfaces is first.surfaces
    cell.do(UpdateNode("iiwa.lbr_iiwa_link_7", hidden=True))
    fewer = library.of(elements(cell))
    assert len(asked) == count  # each mesh's own tables are there still
    assert len(fewer.surfaces.made) == 7
    del first, again, fewer
    gc.collect()
    library.of(elements(cell))
    assert len(asked) == count + 7  # nobody had kept them


def test_triangles_of_looks_are_those_of_shapes() -> None:
    cell = Cell()
    cell.load("franka_panda/panda.urdf", "panda")
    cell.load("table/table.urdf", "table")
    seen = elements(cell)
    looks = AppearanceLibrary(cell.meshes).of(seen)
    surfaces = looks.surfaces
    for shape, figure, start in zip(seen.shapes, seen.figures, looks.starts, strict=True):
        if not isinstance(figure.geometry, Mesh):
            assert start.tolist() == [-1, -1, -1, 1]
            continue
        faces = surfaces.faces[start[0] : start[0] + len(shape.triangles)]
        corners = np.concatenate([part.vertices[part.faces] for part in cell.meshes(figure.geometry)])
        np.testing.assert_array_equal(shape.vertices[shape.triangles], corners)
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(flat, axis=1)
        smooth = surfaces.normals[start[1] + faces].mean(axis=1)
        # Where a mesh's own normals look inwards, shading turns them; most look outwards.
        facing = np.einsum("ij,ij->i", smooth, flat)[area > 1e-9]
        assert (facing > 0.0).mean() > 0.9
