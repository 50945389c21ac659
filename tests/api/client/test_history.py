"""History over the contract: two clients who edit, undo and redo; who stands in the way; checkpoints; the commands."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import click
import numpy as np
import pytest
import virtualrobot
from google.protobuf.timestamp_pb2 import Timestamp
from virtualrobot import errors
from virtualrobot.cli.options import Target
from virtualrobot.cli.own_kernel import in_kernel
from virtualrobot.v1 import history_pb2

from tests.api.client.conftest import IIWA, Run
from tests.kernels import KernelProcess, StartKernel, Stubs


@pytest.fixture
def ann(kernel: KernelProcess, stubs: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client with a table in its world."""
    with virtualrobot.connect(kernel.address, name="ann") as client:
        client.scene.add_object("table")
        yield client


@pytest.fixture
def bob(kernel: KernelProcess) -> Iterator[virtualrobot.Client]:
    with virtualrobot.connect(kernel.address, name="bob") as client:
        yield client


def x(client: virtualrobot.Client, name: str = "table") -> float:
    return float(client.scene[name].parent_t_node[0, 3])


def move(client: virtualrobot.Client, to: float, name: str = "table") -> None:
    client.scene.set_pose(name, virtualrobot.pose(to))


def test_a_move_is_undone_and_done_again(ann: virtualrobot.Client) -> None:
    move(ann, 0.1)
    undo = ann.undo()
    assert (undo.kind, undo.label, undo.mine) == ("undo", "took back: moved 'table' by 0.10 m", True)
    assert x(ann) == 0.0
    assert ann.redo().label == "did again: moved 'table' by 0.10 m"
    assert x(ann) == 0.1
    steps = ann.history.list(node="table", limit=4)
    assert [step.kind for step in steps] == ["redo", "undo", "edit", "edit"]
    assert [step.undone for step in steps] == [False, True, False, False]
    assert steps[1].undoes == steps[2].number
    assert steps[3].label == "created 'table'"


def test_only_mine_and_who_stands_in_the_way(ann: virtualrobot.Client, bob: virtualrobot.Client) -> None:
    move(ann, 0.1)
    bob.scene.add_object("chair")
    assert ann.undo(mine=True).nodes == ("table",)
    ann.redo(mine=True)
    move(bob, 0.5)
    with pytest.raises(
        errors.ConflictError, match=r"the pose of 'table' has been changed since, by step \d+ of bob at"
    ):
        ann.undo(mine=True)
    try:
        ann.undo(mine=True)
    except errors.ConflictError as error:
        assert error.metadata["aspect"] == "poses"
        assert error.metadata["label"] == "moved 'table' by 0.40 m"
        bob.undo(int(error.metadata["step"]))
    ann.undo(mine=True)
    assert x(ann) == 0.0
    number = bob.history.list(mine=True, kinds=["edit"], limit=1)[0].number
    with pytest.raises(errors.WrongStateError, match="only yours"):
        ann.undo(number, mine=True)


def test_a_leased_or_moving_robot_is_named(ann: virtualrobot.Client, bob: virtualrobot.Client) -> None:
    arm = bob.load_robot(IIWA, name="arm")
    bob.scene.hide("arm")
    with bob.lease(arm), pytest.raises(errors.LeasedError, match="'arm' is leased by"):
        ann.undo()
    motion = arm.move_joints([1.0] * 7, wait=False)
    with pytest.raises(errors.RobotBusyError, match=rf"the robot 'arm' moves in '{motion.id}'"):
        ann.undo()
    arm.stop()
    with pytest.raises(errors.MotionCancelledError):
        motion.wait()
    assert ann.undo().label == "took back: hid 'arm'"
    assert ann.undo().label == "took back: created 'arm'"
    assert "arm" not in ann.robots()


def test_a_repeated_call_undoes_once(ann: virtualrobot.Client) -> None:
    move(ann, 0.1)
    assert ann.history.undo(request_id="once") == ann.history.undo(request_id="once")
    assert [step.kind for step in ann.history.list(limit=2)] == ["undo", "edit"]
    again = ann.history.redo(request_id="again")
    assert again == ann.history.redo(request_id="again")


def test_a_watch_loses_nothing(ann: virtualrobot.Client, bob: virtualrobot.Client) -> None:
    watched = bob.history.watch()
    first = ann.history.list(limit=1)[0].number + 1
    for k in range(20):
        ann.signals.create(f"s{k}")
    ann.undo()
    labels = [next(watched).label for _ in range(21)]
    assert labels == [*(f"created the signal 's{k}'" for k in range(20)), "took back: created the signal 's19'"]
    late = ann.history.watch(first)
    assert [next(late).label for _ in range(21)] == labels


def test_filters_and_pages(ann: virtualrobot.Client, bob: virtualrobot.Client) -> None:
    move(ann, 0.1)
    bob.scene.rename("table", "desk")
    ann.signals.create("go")
    ann.signals["go"] = True
    steps = ann.history.list(limit=4)
    assert [step.kind for step in steps] == ["signal", "edit", "edit", "edit"]
    assert [step.author.partition(" at ")[0] for step in ann.history.list(node="desk", limit=2)] == ["bob", "ann"]
    assert ann.history.list(node="table", author="BOB", limit=1)[0].label == "renamed 'table' to 'desk'"
    assert all(step.mine for step in ann.history.list(mine=True))
    later = datetime.now(UTC) + timedelta(hours=1)
    assert not ann.history.list(since=later)
    assert ann.history.list(until=later, limit=1)[0].label == "set the signal 'go' to True"
    assert ann.history.list(kinds=["signal"], limit=1)[0].number == steps[0].number
    with pytest.raises(errors.InvalidArgumentError, match="a kind of steps is one of edit, undo"):
        ann.history.list(kinds=["edits"])


def test_numbers_of_no_step(ann: virtualrobot.Client) -> None:
    for number in (0, 2**63, 2**64 - 1):
        with pytest.raises(errors.WrongStateError, match="is no step of this history"):
            ann.undo(number)
    with pytest.raises(errors.InvalidArgumentError, match="page_token must be"):
        ann.services.history.ListSteps(history_pb2.ListStepsRequest(page_token="9" * 19))
    for seconds, nanos in ((10**15, 0), (-(10**15), 0), (0, -1), (0, 10**9)):
        since = Timestamp(seconds=seconds, nanos=nanos)
        with pytest.raises(errors.InvalidArgumentError, match="since is no time between the years 1 and 9999"):
            ann.services.history.ListSteps(history_pb2.ListStepsRequest(since=since))
    with pytest.raises(errors.InvalidArgumentError, match="page_size is at most 1000"):
        ann.services.history.ListSteps(history_pb2.ListStepsRequest(page_size=1001))
    assert next(iter(ann.services.history.WatchSteps(history_pb2.WatchStepsRequest(from_number=2**64 - 1)))).stamp


def test_a_guard_keeps_an_undo_from_bringing_robots_into_touch(ann: virtualrobot.Client) -> None:
    ann.load_robot(IIWA, name="arm")
    ann.scene.add_object("block", virtualrobot.box(0.2, 0.2, 0.2), pose=virtualrobot.pose(0.0, 0.0, 0.6))
    ann.scene.remove("block")
    ann.collisions.set(mode="guard")
    with pytest.raises(errors.CollisionError, match="'block'"):
        ann.undo(ann.history.list(node="block", limit=1)[0].number)
    assert "block" not in ann.scene


def test_undo_across_a_cleared_world(ann: virtualrobot.Client) -> None:
    move(ann, 0.1)
    moved = ann.history.list(limit=1)[0].number
    ann.scene.clear()
    with pytest.raises(errors.ConflictError, match=r"is gone, by step \d+ of ann .*: cleared the world"):
        ann.undo(moved)
    ann.undo()
    ann.undo(moved)
    assert x(ann) == 0.0


def test_a_checkpoint_brings_joints_back_and_there_is_a_way_back(ann: virtualrobot.Client) -> None:
    arm = ann.load_robot(IIWA, name="arm")
    ann.scene.set_joint_positions("arm", [0.1] * 7)
    made = ann.history.checkpoint("noon")
    assert made.node_count == len(ann.scene.nodes())
    motion = arm.move_joints([1.0] * 7, wait=False)
    ann.scene.remove("table")
    before = ann.history.restore("noon")
    np.testing.assert_array_equal(arm.positions, [0.1] * 7)
    assert "table" in ann.scene
    with pytest.raises(errors.MotionCancelledError, match="went back to the checkpoint 'noon'") as ended:
        motion.wait()
    assert ended.value.metadata["end_cause"] == "world_restored"
    assert before.automatic
    ann.history.restore(before.name)
    assert "table" not in ann.scene
    with pytest.raises(errors.WrongStateError, match="go back to a checkpoint instead"):
        ann.undo(ann.history.list(kinds=["restore"], limit=1)[0].number)


def test_names_of_checkpoints(ann: virtualrobot.Client) -> None:
    assert ann.history.checkpoint().name == "checkpoint 1"
    ann.history.checkpoint("noon")
    assert list(ann.history.checkpoints) == ["checkpoint 1", "noon"]
    with pytest.raises(errors.NameTakenError, match="'noon' is taken by another checkpoint"):
        ann.history.checkpoint("noon")
    with pytest.raises(errors.UnknownNameError, match="did you mean 'noon'"):
        ann.history.restore("non")
    ann.history.remove_checkpoint("noon")
    assert list(ann.history.checkpoints) == ["checkpoint 1"]


def test_what_is_restored_may_not_be_leased(ann: virtualrobot.Client, bob: virtualrobot.Client) -> None:
    ann.load_robot(IIWA, name="arm")
    ann.history.checkpoint("noon")
    with bob.lease("arm"), pytest.raises(errors.LeasedError, match="'arm' is leased"):
        ann.history.restore("noon")


@pytest.mark.long
def test_all_of_it_is_there_after_a_restart(start_kernel: StartKernel, tmp_path: Path) -> None:
    """Steps from before can be undone, who did them is told, and the world goes back to a checkpoint of then."""
    kernel = start_kernel("--data", str(tmp_path))
    with virtualrobot.connect(kernel.address, name="ann") as client:
        client.scene.add_object("table")
        move(client, 0.1)
        client.history.checkpoint("noon")
        client.scene.hide("table")
        client.undo()
    kernel.process.kill()
    kernel.process.wait()
    kernel = start_kernel("--data", str(tmp_path))
    with virtualrobot.connect(kernel.address, name="ann") as client:
        assert x(client) == 0.1
        assert [step.label for step in client.history.list(mine=True, limit=3)] == [
            "took back: hid 'table'",
            "hid 'table'",
            "moved 'table' by 0.10 m",
        ]
        client.redo()
        assert client.scene["table"].hidden
        client.undo()
        client.undo()
        assert x(client) == 0.0
        client.scene.clear()
        before = client.history.restore("noon")
        assert x(client) == 0.1
        client.history.restore(before.name)
        assert "table" not in client.scene
        with pytest.raises(virtualrobot.WrongStateError, match=r"'before step 10'.* stands in between"):
            client.undo()


def test_an_application_goes_by_its_own_name(kernel: KernelProcess, run: Run) -> None:
    run("add", "box", "crate", "--size", "0.1,0.1,0.1")
    of_ours = signal.getsignal(signal.SIGTERM)
    try:
        with (
            click.Context(click.Command("demo"), info_name="virtualrobot demo"),
            in_kernel(Target(kernel.address), headless=True, speed=None) as client,
        ):
            client.scene.add_object("chair")
            assert "virtualrobot demo" in client.history.list(limit=1)[0].author
            assert client.undo(mine=True).label == "took back: created 'chair'"
            client.redo(mine=True)
    finally:
        signal.signal(signal.SIGTERM, of_ours)
    assert run("undo", "--mine") == "took back: created 'crate'\n"


def test_commands(run: Run) -> None:
    run("add", "box", "crate", "--size", "0.1,0.1,0.1")
    run("rename", "crate", "case")
    assert run("undo", "--mine") == "took back: renamed 'crate' to 'case'\n"
    assert run("redo") == "did again: renamed 'crate' to 'case'\n"
    assert run("checkpoint", "noon").startswith("kept 2 nodes at tick ")
    run("remove", "case")
    assert "command line" in run("history", "--node", "case", "--last", "1")
    assert run("history", "--last", "1").rstrip().endswith("removed 'case'")
    assert run("history", "--node", "nowhere") == "no step is so\n"
    assert run("history", "--since", "2001-01-01", "--last", "1") == run("history", "--last", "1")
    assert run("history", "--until", "2001-01-01 12:30:00") == "no step is so\n"
    assert "'noon' is no time; write 14:30, " in run("history", "--since", "noon", code=2)
    rows = run("history", "--mine", "--last", "2").splitlines()
    assert rows[0].index("did again") == rows[1].index("removed 'case'")  # where the column begins
    said = run("checkpoint", "noon", "--restore")
    assert said.startswith("went back to noon; the world as it was before is the checkpoint 'before step ")
    assert "noon" in run("checkpoint")
    run("checkpoint", "noon", "--remove")
    assert '"label": "took back' not in run("--json", "history", "--last", "1")
    assert "is no step of this history" in run("undo", "999999999", code=1)
