"""The scene through the client: nodes, changes, batches, watches, annotations."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, pose
from virtualrobot._wire.messages import array_of

from tests.api.client.conftest import IIWA


def test_nodes_are_added_read_and_changed(client: Client, rng: np.random.Generator) -> None:
    world_t_table, table_t_box = (pose(*rng.uniform(-1, 1, 6)) for _ in range(2))
    scene = client.scene
    table = scene.add_object("table", virtualrobot.box(1, 1, 0.1, color="grey"), pose=world_t_table)
    box = scene.add_part("box", virtualrobot.sphere(0.1), pose=table_t_box, parent="table", mass=2.5)
    assert (table.kind, box.kind, box.parent, box._message.part.mass_kilograms) == ("object", "part", "table", 2.5)
    np.testing.assert_allclose(box.pose, world_t_table @ table_t_box, atol=1e-12)
    np.testing.assert_allclose(box.parent_t_node, table_t_box, atol=1e-12)

    table.parent_t_node = np.eye(4)
    np.testing.assert_allclose(box.pose, table_t_box, atol=1e-12)
    box.attach("world")  # stays where it is
    table.parent_t_node = world_t_table
    np.testing.assert_allclose(box.pose, table_t_box, atol=1e-12)
    box.attach("table", np.eye(4))
    np.testing.assert_allclose(box.pose, world_t_table, atol=1e-12)

    box.rename("ball")
    box.hide()
    box.set_figures([virtualrobot.cone(0.1, 0.2), virtualrobot.capsule(0.1, 0.2)])
    again = scene.node("ball")
    assert (again.uid, again.hidden, len(again._message.figures)) == (box.uid, True, 2)
    assert [node.name for node in scene.nodes("part")] == ["ball"]
    assert set(scene.poses()) == {"world", "table", "ball"}
    assert scene.tree() == "world (world)\n└─ table (object)\n   └─ ball (part, hidden)"
    assert "ball (part" in scene._repr_html_()
    table.remove()
    assert [node.name for node in scene.nodes()] == ["world"]


def test_bounds_hold_a_node_and_what_hangs_below_it(client: Client, rng: np.random.Generator) -> None:
    scene = client.scene
    scene.add_object("table", virtualrobot.box(1, 2, 0.1), pose=pose(*rng.uniform(-1, 1, 6)))
    bounds = scene.bounds("table")
    assert bounds is not None
    np.testing.assert_allclose(bounds, [[-0.5, -1.0, -0.05], [0.5, 1.0, 0.05]], atol=1e-7)
    # A cube of 0.2 m on it, turned by 45 degrees about z: half of its diagonal is 0.1 sqrt(2).
    scene.add_part(
        "cube", virtualrobot.box(0.2, 0.2, 0.2), parent="table", pose=pose(0.6, 0, 0.15, yaw=np.pi / 4), mass=1
    )
    bounds = scene.bounds("table")
    assert bounds is not None
    np.testing.assert_allclose(bounds[0], [-0.5, -1.0, -0.05], atol=1e-7)
    np.testing.assert_allclose(bounds[1], [0.6 + 0.1 * np.sqrt(2), 1.0, 0.25], atol=1e-7)
    scene.node("cube").hide()
    assert scene.bounds("cube") is None
    with pytest.raises(virtualrobot.UnknownNameError, match="tabel"):
        scene.bounds("tabel")


def test_twists_are_those_of_joints_and_of_what_carries_them(steps: Client) -> None:
    """Against the Jacobian, and against central differences of poses, two ticks apart, of motions that are smooth."""
    arm = steps.load_robot(IIWA, name="arm", base="floating")
    other = steps.load_robot(IIWA, name="other", base="planar", pose=pose(y=3.0, roll=0.4))
    steps.scene.add_object("load", virtualrobot.box(0.1, 0.1, 0.1), parent=arm.flange, pose=pose(0.1, 0.2, 0.3, 0.4))
    fixed = steps.load_robot(IIWA, name="fixed", pose=pose(y=-3.0, yaw=1.0))
    base, plane = list(arm.coordinates)[:7], list(other.coordinates)[:3]
    turned = [0.2, 0.1, -0.3, np.sqrt(1 - 0.14)]
    bent = {name: 1.0 for name in list(arm.coordinates)[7:]}
    arm.move_joints(dict(zip(base, [0.5, -0.3, 0.2, *turned], strict=True)) | bent, speed_factor=0.2, wait=False)
    more = {name: -0.8 for name in list(other.coordinates)[3:]}
    other.move_joints(dict(zip(plane, [0.4, 0.6, 1.2], strict=True)) | more, speed_factor=0.2, wait=False)
    fixed.move_joints([0.9, 0.4, -0.7, -1.1, 0.3, 0.8, 0.5], speed_factor=0.2, wait=False)
    names = ["load", arm.flange, other.flange, fixed.flange]
    seen = []
    for _ in range(90):
        steps.clock.step(1)
        seen.append((steps.scene.twists(*names), steps.scene.poses(names)))
    moved = 0.0
    for (_, before), (twists, here), (_, after) in zip(seen[40:], seen[41:], seen[42:], strict=False):
        for name in names:
            velocity = (after[name][:3, 3] - before[name][:3, 3]) / 0.008
            spin = (after[name] - before[name])[:3, :3] @ here[name][:3, :3].T / 0.008
            turning = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / 2.0
            np.testing.assert_allclose(twists[name], [*velocity, *turning], atol=2e-3)
            moved = max(moved, float(np.abs(twists[name]).max()))
    assert moved > 0.3
    jacobian = fixed.solve_jacobian().tcp @ fixed.state.velocities
    np.testing.assert_allclose(steps.scene.twists(fixed.flange)[fixed.flange], jacobian, atol=1e-9)
    assert not steps.scene.twists("world")["world"].any()
    with pytest.raises(virtualrobot.InvalidArgumentError, match="names is empty"):
        steps.scene.twists()


def test_refusals_carry_reason_and_values(client: Client) -> None:
    client.scene.add_object("table")
    with pytest.raises(virtualrobot.UnknownNameError, match="'table'") as unknown:
        client.scene.node("tabel")
    assert "table" in unknown.value.metadata["valid"]
    assert (unknown.value.reason, unknown.value.code) == ("UNKNOWN_NAME", "NOT_FOUND")
    with pytest.raises(virtualrobot.NameTakenError):
        client.scene.add_object("table")
    with pytest.raises(virtualrobot.InvalidArgumentError):
        client.scene.add_part("box", virtualrobot.box(-1, 1, 1))


def test_a_batch_is_all_or_none(client: Client) -> None:
    scene = client.scene
    with scene.batch() as batch:
        assert batch.add_object("a") == "a"
        batch.add_object("b", parent="a")
        batch.create_signal("s", True)
    assert {node.name for node in scene.nodes()} == {"world", "a", "b"}
    assert client.signals["s"] is True
    with pytest.raises(virtualrobot.UnknownNameError), scene.batch() as batch:
        batch.remove("b")
        batch.remove("c")
    assert {node.name for node in scene.nodes()} == {"world", "a", "b"}
    with pytest.raises(RuntimeError, match="the program's own"), scene.batch() as batch:
        batch.remove("b")
        raise RuntimeError("the program's own")
    assert {node.name for node in scene.nodes()} == {"world", "a", "b"}
    with scene.batch():
        pass  # nothing to apply


def test_a_stale_batch_is_refused(client: Client) -> None:
    revision = client.scene.revision
    with client.scene.batch(expected_structure_revision=revision) as batch:
        batch.add_object("a")
    assert client.scene.revision > revision
    with (
        pytest.raises(virtualrobot.StaleRevisionError),
        client.scene.batch(expected_structure_revision=revision) as batch,
    ):
        batch.add_object("b")


def test_a_cleared_world_takes_the_same_names_again(client: Client) -> None:
    for _ in range(2):
        client.scene.clear()
        assert [node.name for node in client.scene.nodes()] == ["world"]
        assert dict(client.signals) == {}
        arm = client.load_robot(IIWA, name="arm")
        client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), parent=arm.flange)
        client.signals.create("box arrived")
        motion = arm.move_joints([0.5] * 7, speed_factor=0.003, wait=False)
    client.scene.clear()
    with pytest.raises(virtualrobot.MotionCancelledError):
        motion.wait()


def test_changes_are_watched(client: Client) -> None:
    box = client.scene.add_part("box", virtualrobot.box(1, 1, 1))
    watch = client.scene.watch(max_rate=100)
    first = next(watch)
    assert {node.name for node in first.nodes} == set(first.poses) == {"world", "box"}
    box.parent_t_node = pose(x=1.0)
    change = next(change for change in watch if "box" in change.poses)
    assert change.poses["box"][0, 3] == 1.0
    assert change.stamp.state_revision > first.stamp.state_revision
    box.remove()
    assert "box" in next(change for change in watch if change.removed).removed


def test_annotations_are_shown_and_removed(client: Client) -> None:
    client.scene.add_object("table")
    points = client.view.add_points(np.zeros((3, 3)), colors=[[255, 0, 0], [0, 255, 0], [0, 0, 255]], parent="table")
    shown = [
        points,
        client.view.add_lines([[0, 0, 0], [1, 0, 0]], color="red", width=3),
        client.view.add_frame(pose(z=1), length=0.2),
        client.view.add_label("here", pose(z=2), name="note"),
    ]
    assert [node.kind for node in shown] == ["annotation"] * 4
    assert shown[3].name == "note"
    assert points.parent == "table"
    figure = points._message.figures[0]
    np.testing.assert_array_equal(array_of(figure.points.colors), [[255, 0, 0], [0, 255, 0], [0, 0, 255]])
    for node in shown:
        node.remove()
    assert client.scene.nodes("annotation") == []


def test_the_view_is_set_up(client: Client) -> None:
    client.scene.add_object("table", virtualrobot.box(1, 1, 1))
    view = client.view
    view.background = "#336699"
    np.testing.assert_allclose(view.background, np.array([0x33, 0x66, 0x99]) / 255)
    view.grid = False
    assert view.grid is False
    view.bounding_boxes = ["table"]
    assert view.bounding_boxes == ["table"]
    watch = view.watch()
    next(watch)
    view.set_camera((2, 1, 1), (0, 0, 0.5), field_of_view=1.0)
    seen = next(watch)
    assert (seen.camera_position[0], seen.camera_target[2], seen.field_of_view) == (2, 0.5, 1.0)
    with pytest.raises(virtualrobot.UnknownNameError):
        view.joint_axes = ["nobody"]
    view.grid, view.bounding_boxes = True, []
