"""What rays can meet of a world: which figures, where, and when they are gathered anew."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.commands import CreateNodes, SetJointPositions, SetToolState, UpdateNode
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Frame, Label, Material, Mesh, Sphere
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, NodeSpec, ToolData
from virtualrobot_sdk.rays import Primitive, Round

from tests.drawing.cell import Cell, at


@pytest.fixture
def cell() -> Cell:
    """Return an iiwa with a gripper that shows a plate only while it is open, a part, and something for people."""
    cell = Cell()
    cell.load("kuka_iiwa/model.urdf", "iiwa")
    tool = ToolData(states={"open": {}, "closed": {}})
    figures = (Figure(Box((0.1, 0.1, 0.02)), tool_state="open"), Figure(Sphere(0.03), collision=False))
    shown = Material(reflectance=0.9)
    cell.do(
        CreateNodes(
            (
                NodeSpec("gripper", Kind.TOOL, "iiwa.lbr_iiwa_link_7", figures=figures, data=tool),
                NodeSpec(
                    "part",
                    Kind.PART,
                    parent_t_node=at(1.0, 0.0, 0.5),
                    figures=(Figure(Box((1, 1, 1)), material=shown),),
                ),
                NodeSpec("note", Kind.ANNOTATION, figures=(Figure(Sphere(1.0)), Figure(Label("a note")))),
                NodeSpec("marked", Kind.OBJECT, figures=(Figure(Frame()), Figure(Box((1, 1, 1)), visual=False))),
            )
        )
    )
    return cell


def test_what_is_seen_is_what_is_visible_and_solid(cell: Cell) -> None:
    elements = elements_of(cell.snapshot, ShapeLibrary(cell.meshes))
    nodes = cell.snapshot.structure.nodes
    names = [nodes[uid].name for uid in elements.uids.tolist()]
    assert names.count("gripper") == 2
    assert names.count("part") == 1
    assert {"note", "marked"}.isdisjoint(names)
    assert sum(name.startswith("iiwa.") for name in names) == 8  # base and seven links, a mesh each
    assert elements.reflectance[names.index("part")] == 0.9
    assert elements.reflectance[0] == 0.5
    poses = elements.world_t_element(cell.snapshot.world_t_node)
    np.testing.assert_array_equal(poses[names.index("part")], at(1.0, 0.0, 0.5))


def test_hidden_nodes_tool_states_and_unseen_nodes(cell: Cell) -> None:
    library = ShapeLibrary(cell.meshes)
    uid = cell.snapshot.structure.uid_by_name
    all_of_them = len(elements_of(cell.snapshot, library).shapes)
    assert len(elements_of(cell.snapshot, library, unseen=frozenset({uid["part"]})).shapes) == all_of_them - 1
    cell.do(SetToolState("gripper", "closed"))
    assert len(elements_of(cell.snapshot, library).shapes) == all_of_them - 1
    cell.do(UpdateNode("iiwa", hidden=True))
    assert [uid["part"]] == elements_of(cell.snapshot, library).uids.tolist()


def test_a_sensor_looks_out_of_its_housing(cell: Cell) -> None:
    """A link's figures that the sensor stands in do not count for it, as long as it stands in them."""
    library, eye = ShapeLibrary(cell.meshes), RangeSensor()
    housing, plate = Figure(Box((0.1, 0.1, 0.1)), at(0.0, 0.0, 0.05)), Figure(Box((0.3, 0.3, 0.01)), at(0.0, 0.0, 0.2))
    mount = LinkData(Joint("mount", JointType.FIXED, axis=(0.0, 0.0, 1.0)))
    cell.add("holder", kind=Kind.ROBOT)
    cell.add("holder.head", housing, plate, parent="holder", kind=Kind.LINK, data=mount)
    cell.add("inside", parent="holder.head", pose=at(0.0, 0.0, 0.06), kind=Kind.RANGE_SENSOR, data=eye)
    cell.add("within", parent="part", kind=Kind.RANGE_SENSOR, data=eye)
    uid = cell.snapshot.structure.uid_by_name

    def heads(elements: Elements) -> int:
        return int((elements.uids == uid["holder.head"]).sum())

    unseen = frozenset({uid["inside"]})
    assert heads(elements_of(cell.snapshot, library)) == 2
    seen = elements_of(cell.snapshot, library, unseen=unseen)
    assert heads(seen) == 1 and elements_of(cell.snapshot, library, seen, unseen) is seen
    cell.do(UpdateNode("inside", parent_t_node=at(0.0, 0.0, 0.12)))
    assert heads(elements_of(cell.snapshot, library, seen, unseen)) == 2
    cell.do(UpdateNode("inside", parent_t_node=at(0.0, 0.0, 0.101)))  # at its front
    assert heads(elements_of(cell.snapshot, library, seen, unseen)) == 1
    # What is no link hides what is in it: one may stand in a room.
    assert uid["part"] in elements_of(cell.snapshot, library, unseen=frozenset({uid["within"]})).uids


def test_they_are_gathered_anew_only_when_something_else_than_poses_changes(
    cell: Cell, rng: np.random.Generator
) -> None:
    library = ShapeLibrary(cell.meshes)
    first = elements_of(cell.snapshot, library)
    cell.do(SetJointPositions("iiwa", coordinates=rng.uniform(-1.0, 1.0, 7)))
    again = elements_of(cell.snapshot, library, first)
    assert again is first
    cell.do(UpdateNode("part", hidden=True))
    other = elements_of(cell.snapshot, library, again)
    assert len(other.shapes) == len(first.shapes) - 1
    assert all(shape is before for shape, before in zip(other.shapes[:8], first.shapes[:8], strict=True))


@pytest.mark.parametrize(
    ("geometry", "primitive"),
    [
        (Sphere(0.4), Primitive(Round.SPHERE, 0.4)),
        (Cylinder(0.2, 1.0), Primitive(Round.CYLINDER, 0.2, 1.0)),
        (Cone(0.2, 1.0), Primitive(Round.CONE, 0.2, 1.0)),
        (Capsule(0.2, 1.0), Primitive(Round.CAPSULE, 0.2, 1.0)),
        (Box((0.1, 0.2, 0.3)), None),
    ],
    ids=lambda value: type(value).__name__,
)
def test_shapes_are_as_large_as_their_geometry(geometry: Sphere, primitive: Primitive | None) -> None:
    shape = ShapeLibrary(lambda mesh: ()).get(geometry)
    assert shape is not None
    assert shape.primitive == primitive
    extent = np.ptp(shape.vertices, axis=0)
    match primitive:
        case None:
            np.testing.assert_allclose(extent, (0.1, 0.2, 0.3), rtol=1e-6)
        case Primitive(kind, radius, length):
            caps = 2.0 * radius if kind in (Round.SPHERE, Round.CAPSULE) else 0.0
            np.testing.assert_allclose(extent, (2 * radius, 2 * radius, length + caps), rtol=3e-3)  # facets


def test_a_mesh_that_cannot_be_read_is_seen_as_nothing(cell: Cell) -> None:
    lost = Mesh("lost.stl", "0" * 64)
    cell.do(CreateNodes((NodeSpec("lost", Kind.OBJECT, figures=(Figure(lost),)),)))
    elements = elements_of(cell.snapshot, ShapeLibrary(cell.meshes))
    assert len(elements.shapes[elements.figures.index(cell.snapshot.structure.node("lost").figures[0])].triangles) == 0
