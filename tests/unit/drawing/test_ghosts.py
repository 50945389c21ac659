"""Which figures ghosts are made of, and where these are."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.drawing.ghosts import SLIM, ghost_figures, slimmer
from virtualrobot_kernel.drawing.view import Ghost
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Mesh, Sphere
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData

from tests.drawing.cell import Cell, at


def slide(cell: Cell, name: str, parent: str = "world") -> None:
    """Add a robot that goes along x: a pedestal that stands, a carriage, and on it an arm that turns about z."""
    cell.add(name, kind=Kind.ROBOT, parent=parent, pose=at(0.0, 0.0, 1.0))
    fixed = LinkData(Joint("foot", JointType.FIXED))
    cell.add(f"{name}.pedestal", Figure(Box((1.0, 1.0, 1.0))), parent=name, kind=Kind.LINK, data=fixed)
    along = LinkData(Joint("along", JointType.PRISMATIC, axis=(1.0, 0.0, 0.0)))
    cell.add(f"{name}.carriage", Figure(Box((0.2, 0.2, 0.2))), parent=f"{name}.pedestal", kind=Kind.LINK, data=along)
    turn = LinkData(Joint("turn", JointType.REVOLUTE, axis=(0.0, 0.0, 1.0)))
    arm = Figure(Sphere(0.1), at(0.5, 0.0, 0.0))
    cell.add(f"{name}.arm", arm, parent=f"{name}.carriage", kind=Kind.LINK, data=turn)


def places(cell: Cell, *rows: tuple[float, float]) -> list[tuple[type, list[float]]]:
    found = ghost_figures(cell.snapshot, (Ghost("g", cell.uid("slide"), rows, (1.0, 0.0, 0.0), 0.5),))
    told = []
    for uid, figure in found:
        assert uid == cell.uid("slide") and figure.material is not None
        assert figure.material.color == (1.0, 0.0, 0.0, 0.5)
        told.append((type(figure.geometry), figure.node_t_figure[:3, 3].round(12).tolist()))
    return told


def test_what_joints_move_is_where_they_bring_it_in_the_robots_frame() -> None:
    cell = Cell()
    slide(cell, "slide")
    cell.do(SetJointPositions("slide", {"along": 3.0}))
    assert places(cell, (2.0, np.pi / 2)) == [(Box, [2.0, 0.0, 0.0]), (Sphere, [2.0, 0.5, 0.0])]


def test_what_is_at_one_place_in_several_configurations_comes_once() -> None:
    cell = Cell()
    slide(cell, "slide")
    spheres = [(Sphere, [1.5, 0.0, 0.0]), (Sphere, [0.5, 0.0, 0.0])]
    assert places(cell, (1.0, 0.0), (1.0, np.pi), (1.0, 0.0)) == [(Box, [1.0, 0.0, 0.0]), *spheres]


def test_parts_that_it_carries_count_and_robots_that_stand_on_it_do_not() -> None:
    cell = Cell()
    slide(cell, "slide")
    cell.add("load", Figure(Box((0.1, 0.1, 0.1))), parent="slide.carriage", pose=at(0.0, 0.0, 0.3), kind=Kind.PART)
    slide(cell, "second", parent="slide.carriage")
    found = places(cell, (1.0, 0.0))
    assert sorted(place for _, place in found) == [[1.0, 0.0, 0.0], [1.0, 0.0, 0.3], [1.5, 0.0, 0.0]]


def test_a_ghost_of_a_robot_with_other_joints_is_passed_over() -> None:
    cell = Cell()
    slide(cell, "slide")
    assert not list(ghost_figures(cell.snapshot, (Ghost("g", cell.uid("slide"), ((0.0,),)),)))
    assert not list(ghost_figures(cell.snapshot, (Ghost("g", 999, ((0.0, 0.0),)),)))


def test_where_ghost_and_robot_are_at_one_place_the_robot_is_outside() -> None:
    """Faces at one place would be drawn as speckles of both."""
    solids = Box((1, 2, 3)), Sphere(1), Cylinder(1, 2), Cone(1, 2), Capsule(1, 2), Mesh("m.stl", "0" * 64, (1, 2, 3))
    for solid in solids:
        thin = slimmer(solid)
        assert type(thin) is type(solid) and thin != solid
        sizes = [
            [
                float(value)
                for name in ("size", "radius", "length", "scale")
                for value in np.ravel(getattr(one, name, ()))
            ]
            for one in (thin, solid)
        ]
        np.testing.assert_allclose(sizes[0], SLIM * np.array(sizes[1]))
