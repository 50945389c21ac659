"""What is drawn: grouped, inherited, and taken over from one structure to the next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.drawing.annotations import box_edges
from virtualrobot_kernel.drawing.batches import wxyz_of
from virtualrobot_kernel.drawing.inventory import joint_axes, node_bounds, take, turned_to, world_bounds
from virtualrobot_kernel.drawing.library import AXIS_ARROW, ShapeLibrary
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Figure, Label, Material, Mesh, Sphere
from virtualrobot_kernel.world.structure import (
    WORLD_UID,
    Joint,
    JointType,
    Kind,
    LinkData,
    Node,
    RobotData,
    Structure,
    ToolData,
)

RED = Material((1.0, 0.0, 0.0, 1.0))
WORLD = Node(WORLD_UID, "world", Kind.WORLD, 0)


def no_meshes(mesh: Mesh) -> tuple[Submesh, ...]:
    raise AssertionError(f"{mesh} was asked for")


def built(*nodes: Node) -> Structure:
    return index.build({node.uid: node for node in (WORLD, *nodes)}, 100, 1)


def at(*position: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = position
    return pose


def test_boxes_of_any_size_and_one_colour_are_one_batch() -> None:
    nodes = [
        Node(uid, f"box{uid}", Kind.PART, 1, figures=(Figure(Box((uid, 1, 1)), material=RED),)) for uid in (2, 3, 4)
    ]
    inventory = take(built(*nodes), {})
    (key,) = inventory.batches
    assert key == ("box", (1.0, 0.0, 0.0, 1.0))
    batch = inventory.batches[key]
    assert batch.rows.tolist() == [1, 2, 3]
    assert batch.scale[:, 0].tolist() == [2.0, 3.0, 4.0]


def test_capsules_and_meshes_are_grouped_by_value() -> None:
    mesh = Mesh("a.stl", "0" * 64)
    figures = (Figure(Capsule(0.1, 1.0)), Figure(Capsule(0.1, 1.0)), Figure(Capsule(0.2, 1.0)))
    meshes = (Figure(mesh), Figure(replace(mesh)), Figure(replace(mesh, scale=(1.0, 1.0, -1.0))))
    inventory = take(built(Node(2, "a", Kind.OBJECT, 1, figures=(*figures, *meshes))), {})
    assert sorted(len(batch.rows) for batch in inventory.batches.values()) == [1, 1, 2, 2]


def test_collision_figures_are_not_drawn() -> None:
    inventory = take(built(Node(2, "a", Kind.OBJECT, 1, figures=(Figure(Sphere(1.0), visual=False),))), {})
    assert not inventory.batches


def test_what_is_below_a_hidden_node_is_hidden_but_stays_in_the_browser() -> None:
    figures = (Figure(Sphere(1.0)), Figure(Label("here")))
    child = Node(3, "child", Kind.PART, 2, figures=figures)
    shown = take(built(Node(2, "parent", Kind.OBJECT, 1), child), {})
    hidden = take(built(Node(2, "parent", Kind.OBJECT, 1, hidden=True), child), {})
    assert len(shown.batches) == 1 and len(shown.annotations) == 1
    assert not hidden.batches and not hidden.annotations and not hidden.visible
    assert hidden.used == shown.used


def test_figures_of_a_tool_state_show_in_that_state_only() -> None:
    figures = (
        Figure(Sphere(1.0)),
        Figure(Cylinder(1.0, 1.0), tool_state="open"),
        Figure(Box((1.0, 1.0, 1.0)), tool_state="closed"),
    )
    tool = Node(2, "tool", Kind.TOOL, 1, figures=figures, data=ToolData(states={"open": {}, "closed": {}}))
    finger = Node(3, "finger", Kind.OBJECT, 2, figures=(Figure(Capsule(0.1, 0.1), tool_state="closed"),))
    structure = built(tool, finger)

    def shapes(states: dict[int, str]) -> set[str]:
        return {key if isinstance(key, str) else "capsule" for key, _ in take(structure, states).batches}

    assert shapes({}) == {"sphere", "cylinder"}  # the first state is the default
    assert shapes({2: "closed"}) == {"sphere", "box", "capsule"}


def test_only_new_nodes_are_looked_at_anew() -> None:
    nodes = [Node(uid, f"n{uid}", Kind.PART, 1, figures=(Figure(Sphere(0.1)),)) for uid in range(2, 500)]
    before = take(built(*nodes), {})
    moved = replace(nodes[7], parent=nodes[8].uid)
    after = take(built(*nodes[:7], moved, *nodes[8:]), {}, before=before)
    kept = [node for node in after.looks if before.looks.get(node) is after.looks[node]]
    assert len(after.looks) - len(kept) == 1


def robot(*joints: Joint) -> Structure:
    nodes = [Node(2, "robot", Kind.ROBOT, 1, data=RobotData())]
    for count, joint in enumerate(joints):
        figures = (Figure(Box((0.2, 0.2, 1.0))),)
        nodes.append(Node(3 + count, f"link{count}", Kind.LINK, 2 + count, figures=figures, data=LinkData(joint)))
    return built(*nodes)


def test_each_moving_joint_has_an_arrow_along_its_axis() -> None:
    tilted = (0.6, 0.0, 0.8)
    structure = robot(
        Joint("a", JointType.REVOLUTE, tilted), Joint("b", JointType.FIXED), Joint("c", JointType.PRISMATIC, (0, -1, 0))
    )
    axes = joint_axes(structure, (2, 77), ShapeLibrary(no_meshes))
    assert [uid for uid, _ in axes] == [3, 5]
    assert [piece.key[0] for _, piece in axes] == [AXIS_ARROW, AXIS_ARROW]
    assert axes[0][1].key != axes[1][1].key  # turning and sliding joints differ in colour
    assert axes[0][1].node_t_shape[:3, 2] == pytest.approx(tilted)
    assert axes[1][1].node_t_shape[:3, 2] == pytest.approx((0, -1, 0))
    assert axes[0][1].scale[0] == pytest.approx(1.5 * np.sqrt(0.1**2 + 0.1**2 + 0.5**2))  # reach of its corners
    inventory = take(structure, {}, axes)
    assert sum(len(batch.rows) for key, batch in inventory.batches.items() if key[0] == AXIS_ARROW) == 2


def test_turned_to_is_a_rotation(rng: np.random.Generator) -> None:
    for axis in [*rng.normal(size=(100, 3)), (0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0)]:
        unit = np.asarray(axis) / np.linalg.norm(axis)
        pose = turned_to(tuple(unit))
        assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(pose) == pytest.approx(1.0)
        assert pose[:3, 2] == pytest.approx(unit)


def test_bounds_are_tight_in_the_nodes_frame_and_cover_its_children(rng: np.random.Generator) -> None:
    """A box of 1 x 2 x 3 m with a child ball of 0.5 m at x = 2: from -0.5 to 2.5 in x, however the parent lies."""
    child = Node(3, "child", Kind.PART, 2, figures=(Figure(Sphere(0.5)),))
    structure = built(Node(2, "parent", Kind.OBJECT, 1, figures=(Figure(Box((1.0, 2.0, 3.0))),)), child)
    direction = rng.normal(size=3)
    pose = turned_to(tuple(direction / np.linalg.norm(direction)))
    pose[:3, 3] = rng.normal(size=3)
    world_t_node = np.array([np.eye(4), pose, pose @ at(2.0, 0.0, 0.0)])
    inventory, library = take(structure, {}), ShapeLibrary(no_meshes)
    box = node_bounds(structure, inventory, world_t_node, library, 2)
    assert box is not None
    assert box == pytest.approx(np.array([[-0.5, -1.0, -1.5], [2.5, 1.0, 1.5]]), abs=0.005)
    everything = world_bounds(inventory, world_t_node, library)
    assert everything is not None
    corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T @ pose[:3, :3].T + pose[:3, 3]
    assert (everything[0] < corners.max(axis=0)).all() and (everything[1] > corners.min(axis=0)).all()


def test_a_floor_does_not_count_beside_other_things() -> None:
    floor = Node(2, "floor", Kind.OBJECT, 1, figures=(Figure(Box((200.0, 200.0, 0.1))),))
    ball = Node(3, "ball", Kind.PART, 1, figures=(Figure(Sphere(1.0)),))
    world_t_node, library = np.tile(np.eye(4), (3, 1, 1)), ShapeLibrary(no_meshes)
    both = world_bounds(take(built(floor, ball), {}), world_t_node, library)
    alone = world_bounds(take(built(floor), {}), world_t_node, library)
    assert both is not None and alone is not None
    assert np.ptp(both, axis=0) == pytest.approx((2.0, 2.0, 2.0))
    assert np.ptp(alone, axis=0).max() == pytest.approx(200.0)


def test_nothing_visible_has_no_bounds() -> None:
    structure, library = built(), ShapeLibrary(no_meshes)
    assert node_bounds(structure, take(structure, {}), np.eye(4)[None], library, 1) is None


def test_a_box_has_twelve_edges_of_its_lengths() -> None:
    edges = box_edges(np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]))
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    assert sorted(lengths) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4
    assert len(np.unique(edges.reshape(-1, 3), axis=0)) == 8


def test_quaternions_turn_as_their_matrices(rng: np.random.Generator) -> None:
    """R(q) p = q p q*, checked by the formula of the rotation matrix of a unit quaternion (Diebel 2006, eq. 125)."""
    quaternions = rng.normal(size=(1000, 4))
    quaternions[:8] = np.concatenate([np.eye(4), -np.eye(4)])  # no turn, and half turns about each axis
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    w, x, y, z = quaternions.T
    matrices = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    assert np.abs(np.einsum("ij,ij->i", wxyz_of(matrices), quaternions)) == pytest.approx(1.0, abs=1e-12)


def test_a_bad_mesh_is_told_once_and_drawn_as_nothing(caplog: pytest.LogCaptureFixture) -> None:
    def broken(mesh: Mesh) -> tuple[Submesh, ...]:
        raise MalformedFileError(f"{mesh.uri}: cut off")

    library = ShapeLibrary(broken)
    for _ in range(3):
        assert library.files(Mesh("arm.stl", "0" * 64), None) == ()
    assert [record.getMessage() for record in caplog.records] == ["mesh arm.stl is not drawn"]
