"""Steps: what is listed, which one undo and redo take, and who is named when something stands in the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from typing import get_args

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history import stored_steps
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.labels import LABELS
from virtualrobot_kernel.history.step import KINDS, Step, StepKind
from virtualrobot_kernel.history.steps import Steps, Wanted, taking_back
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.apply_records import Conflict
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import Entry
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.world.builders import after, part, shifted
from tests.unit.world.edits import cell, random_batch


class Desk:
    """World with a history: what `do` does is a step, a second after the one before."""

    def __init__(self) -> None:
        """Begin with the cell."""
        self.now = cell()
        self.store = Store()
        self.kept = StoredSteps(self.store, world_codec())
        self.steps = Steps(self.kept)
        self.number, self.time = 0, 1000.0

    def do(self, author: str, *batch: Command, seconds: float = 1.0) -> Step:
        """Apply a batch; return its step."""
        self.number, self.time = self.number + 1, self.time + seconds
        later = after(self.now, *batch)
        told = Told(self.number, Entry(self.now.state.tick, author, batch, self.time), self.now, later)
        self.keep(told)
        self.now = later
        step = self.steps.store.get(self.number)
        assert step is not None
        return step

    def keep(self, told: Told) -> None:
        """Have an entry kept as the journal does, into the store."""
        self.steps.keep([told])
        self.store.write((), self.kept.waiting())
        self.kept.written()

    def undo(self, author: str = "ann", **which: object) -> Step:
        """Take a step back, as the service does."""
        return self.do(author, taking_back(self.steps.to_undo(**which)))  # pyright: ignore[reportArgumentType]

    def redo(self, author: str = "ann", **which: object) -> Step:
        """Take an undo back, as the service does."""
        return self.do(author, taking_back(self.steps.to_redo(**which)))  # pyright: ignore[reportArgumentType]

    def x(self, name: str = "table") -> float:
        """Return where a node is in its parent's frame."""
        return float(self.now.state.parent_t_node[self.now.structure.rows[self.now.structure.uid_by_name[name]]][0, 3])


GO = Signal("go", True)
HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])


def moved(x: float, name: str = "table") -> commands.UpdateNode:
    return commands.UpdateNode(name, parent_t_node=shifted(x=x))


@pytest.fixture
def desk() -> Desk:
    return Desk()


def ann(author: str) -> bool:
    return author == "ann"


def test_every_command_has_a_label() -> None:
    assert LABELS.keys() == set(get_args(commands.Command))
    assert KINDS.keys() < LABELS.keys()


@pytest.mark.parametrize(
    ("batch", "label"),
    [
        ((moved(0.1),), "moved 'table' by 0.10 m"),
        (
            (commands.UpdateNode("table", parent_t_node=np.diag([-1.0, -1.0, 1.0, 1.0])),),
            "moved 'table' by 180 degrees",
        ),
        ((commands.UpdateNode("table", parent_t_node=shifted(y=0.0032)),), "moved 'table' by 3.2 mm"),
        ((commands.UpdateNode("table", new_name="desk"),), "renamed 'table' to 'desk'"),
        ((commands.UpdateNode("table", hidden=True),), "hid 'table'"),
        ((commands.UpdateNode("table", locked=True, tags=("a",)),), "locked 'table', changed the tags of 'table'"),
        ((commands.UpdateNode("table", figures=(Figure(Box((1, 1, 1))),)),), "changed the figures of 'table'"),
        ((commands.CreateNodes(tuple(part(f"box_{k}", shifted()) for k in range(5))),), "created 'box_0' and 4 others"),
        ((commands.CreateNodes((NodeSpec("a", Kind.OBJECT), NodeSpec("b", Kind.OBJECT, "a"))),), "created 'a'"),
        ((commands.RemoveNode("part_0"), commands.RemoveNode("part_1")), "removed 'part_0' and 'part_1'"),
        (
            (commands.ClearWorld(), commands.CreateSignal(Signal("go", True))),
            "cleared the world, created the signal 'go'",
        ),
        ((commands.AttachNode("part_0", ""),), "attached 'part_0' to 'world'"),
        ((commands.PickPart("left", max_distance=9.0),), "picked 'part_3' with 'left'"),
        (
            (commands.SelectTool("left", "left_gripper", "side"),),
            "selected the tool 'left_gripper', 'side', for 'left'",
        ),
        ((commands.SelectTool("left"),), "selected no tool for 'left'"),
        ((commands.SetSpeedFactor("", 0.5),), "set the speed factor of all to 0.5"),
        ((commands.SetCollisionSettings(CollisionMode.STOP),), "set collision handling to 'stop'"),
        ((commands.SetCollisionSettings(paddings=(("left", 0.01),)),), "set the padding of 'left' to 0.01 m"),
        ((commands.SetAllowedPairs(allow=(("part_1", "left", ""),)),), "let touch 'part_1' with 'left'"),
        ((commands.SetPostures("left", {"up": {"a": 0.0}}, ("bent",)),), "removed the posture 'bent' of 'left', set"),
        ((commands.SetSignal("ready", True),), "set the signal 'ready' to True"),
        ((commands.SetJointPositions("left", {"a": 0.0}),), "put the joints of 'left' elsewhere"),
        ((commands.RunSensors((), False),), "stopped all sensors"),
        ((commands.SetToolState("left_gripper", "closed"),), "set the tool 'left_gripper' to 'closed'"),
        ((commands.StopMotions(("left",)),), "stopped 'left'"),
        (
            (commands.PickPart("left", max_distance=9.0), commands.PlacePart("left", parent="table")),
            "picked 'part_3' with 'left', placed on 'table' with 'left'",
        ),
    ],
)
def test_labels_say_what_was_done(desk: Desk, batch: tuple[Command, ...], label: str) -> None:
    assert desk.do("ann", *batch).label.startswith(label)


def test_labels_of_random_batches_are_short(rng: np.random.Generator, desk: Desk) -> None:
    for _ in range(30):
        assert 0 < len(desk.do("ann", *random_batch(rng, desk.now)).label) <= 200


def test_the_newest_one_that_stands_is_undone(desk: Desk) -> None:
    for x in (1.0, 2.0, 3.0):
        desk.do("ann", moved(x))
    assert desk.undo().label == "took back: moved 'table' by 1.00 m"
    assert desk.undo("bob").undoes == 2
    assert desk.x() == 1.0
    assert desk.redo().label == "did again: moved 'table' by 1.00 m"
    assert desk.x() == 2.0
    assert desk.undo().undoes == 2
    assert desk.undo().undoes == 1
    with pytest.raises(KernelError, match="there is nothing to undo") as error:
        desk.undo()
    assert error.value.reason is Reason.WRONG_STATE
    for x in (1.0, 2.0, 3.0):
        assert desk.redo().kind is StepKind.REDO
        assert desk.x() == x
    with pytest.raises(KernelError, match="there is nothing to redo"):
        desk.redo()


def test_after_a_new_edit_an_undo_is_taken_back_by_its_number_alone(desk: Desk) -> None:
    desk.do("ann", moved(1.0))
    undone = desk.undo()
    desk.do("ann", moved(1.0, "lidar"))
    with pytest.raises(KernelError, match="nothing was undone since the last change"):
        desk.redo()
    assert desk.redo(number=1).undoes == undone.number
    assert desk.x() == 1.0
    with pytest.raises(KernelError, match=r"step 1 .* is not undone"):
        desk.redo(number=1)


def test_only_mine(desk: Desk) -> None:
    desk.do("ann", moved(1.0))
    bobs = desk.do("bob", moved(1.0, "lidar"))
    assert desk.undo(mine=ann).undoes == 1
    with pytest.raises(KernelError, match="there is nothing of yours to undo"):
        desk.undo(mine=ann)
    with pytest.raises(KernelError, match=r"step 2 .* is of bob, and only yours shall be undone"):
        desk.undo(mine=ann, number=bobs.number)
    desk.do("bob", moved(2.0, "lidar"))
    assert desk.redo(mine=ann).kind is StepKind.REDO
    assert (desk.x(), desk.x("lidar")) == (1.0, 2.0)


def test_who_stands_in_the_way_is_named(desk: Desk) -> None:
    desk.do("ann", moved(1.0))
    desk.do("bob", moved(2.0))
    step = desk.steps.to_undo(1)
    with pytest.raises(Conflict) as error:
        after(desk.now, taking_back(step))
    told = desk.steps.conflict(step, error.value)
    assert str(told) == (
        "cannot take back step 1 (moved 'table' by 1.00 m): the pose of 'table' has been changed since, "
        "by step 2 of bob: moved 'table' by 1.00 m"
    )
    assert told.metadata == {"aspect": "poses", "step": "2", "author": "bob", "label": "moved 'table' by 1.00 m"}


def test_what_cannot_be_undone_says_why(desk: Desk) -> None:
    desk.do("ann", commands.SetJointPositions("left", {"a": 0.0}))
    desk.do("ann", commands.SetSignal("ready", True))
    desk.do("ann", checkpoint_of(desk.now, "noon"))
    with pytest.raises(KernelError, match="motion is not undone; go back to a checkpoint"):
        desk.undo(number=1)
    with pytest.raises(KernelError, match="it changed nothing that undo covers"):
        desk.undo(number=2)
    with pytest.raises(KernelError, match="go back to a checkpoint instead"):
        desk.undo(number=3)
    with pytest.raises(KernelError, match="step 9 is no step of this history"):
        desk.undo(number=9)
    with pytest.raises(KernelError, match="step 0 is no step of this history; they are numbered from 1 on"):
        desk.undo(number=0)


def test_what_is_undone_is_not_undone_again(desk: Desk) -> None:
    desk.do("ann", moved(1.0))
    undo = desk.undo()
    with pytest.raises(KernelError, match=r"is undone already, by step 2"):
        desk.undo(number=1)
    desk.redo(number=undo.number)
    assert desk.undo(number=3).undoes == 1  # the redo's own number means the edit


def test_a_drag_is_one_step(desk: Desk) -> None:
    first = desk.do("ann", moved(0.1))
    for k in range(2, 11):
        desk.do("ann", moved(k / 10), seconds=0.05)
        desk.do("bob", moved(k / 10, "lidar"), seconds=0.05)
    step = desk.steps.store.get(first.number)
    assert step is not None
    assert (step.first_number, step.number, step.label) == (1, 18, "moved 'table' by 1.00 m")
    assert len(list(desk.steps.store.find(Wanted()))) == 2
    desk.undo(number=1)
    assert (desk.x(), desk.x("lidar")) == (0.0, 1.0)


@pytest.mark.parametrize("seconds", [0.6, -5.0])
def test_what_is_no_drag(desk: Desk, seconds: float) -> None:
    """Later, or by a clock that was set back, it is another step."""
    desk.do("ann", moved(0.1))
    assert desk.do("ann", moved(0.2), seconds=seconds).first_number == 2


def test_what_another_changed_in_between_is_no_drag(desk: Desk) -> None:
    desk.do("ann", moved(0.1))
    desk.do("bob", moved(0.2), seconds=0.1)
    assert desk.do("ann", moved(0.3), seconds=0.1).first_number == 3


def test_filters(desk: Desk) -> None:
    desk.do("ann", moved(0.1))
    desk.do("bob", commands.UpdateNode("table", new_name="desk"))
    desk.do("bob", commands.SetSignal("ready", True))

    def found(**wanted: object) -> list[int]:
        return [step.number for step in desk.steps.store.find(Wanted(**wanted))]  # pyright: ignore[reportArgumentType]

    table = frozenset({desk.now.structure.uid_by_name["desk"]})
    assert found() == [3, 2, 1]
    assert found(node="desk", uids=table) == [2, 1]
    assert found(node="table") == [2, 1]
    assert found(node="part_0") == []
    assert found(author="BO") == [3, 2]
    assert found(mine=ann) == [1]
    assert found(since=1002.0, until=1003.0) == [2]
    assert found(kinds=frozenset({StepKind.SIGNAL})) == [3]
    assert [step.number for step in desk.steps.store.find(Wanted(), before=3)] == [2, 1]


def test_an_entry_that_comes_again_is_one_step(desk: Desk) -> None:
    """It does when it could not be written at first."""
    told: list[Sequence[Step]] = []
    desk.steps.subscribe(told.append)
    before = desk.now
    entry = Told(1, Entry(0, "ann", (moved(1.0),), 1000.0), before, after(before, moved(1.0)))
    desk.keep(entry)
    desk.keep(entry)
    assert len(told) == 1
    assert len(list(desk.steps.store.find(Wanted()))) == 1


def test_undo_is_known_again_by_who_reads_the_store(desk: Desk) -> None:
    desk.do("ann", moved(1.0))
    desk.do("ann", moved(2.0))
    desk.undo()
    desk.steps = Steps(desk.kept)
    assert desk.steps.to_undo().number == 1
    assert desk.redo().undoes == 3
    desk.steps = Steps(desk.kept)
    assert desk.undo().undoes == 2


def test_what_a_program_does_is_named_and_not_undone(desk: Desk) -> None:
    """The batch ends with GoOn, as the world thread gives the orders of a motion."""
    before = desk.now
    later = after(before, moved(1.0))
    batch = (moved(1.0), commands.GoOn("motion-1"))
    desk.keep(Told(1, Entry(0, "motion-1", batch), before, later))
    step = desk.steps.store.get(1)
    assert step is not None
    assert (step.kind, step.has("table")) == (StepKind.MOTION, True)


def test_setpoints_are_no_steps(desk: Desk) -> None:
    batch = (commands.SetSetpoint("motion-1", (0.0,)),)
    desk.keep(Told(1, Entry(0, "ann", batch), desk.now, desk.now))
    assert desk.steps.store.last == 0


def test_a_checkpoint_brings_all_back_and_time_goes_on(desk: Desk) -> None:
    start = replace(desk.now, state=replace(desk.now.state, tick=7))
    back = checkpoint_of(start, "noon")
    desk.do("ann", commands.ClearWorld(), commands.CreateNodes((part("box", shifted()),)))
    desk.now = Change(desk.now.structure, replace(desk.now.state, tick=9))
    desk.do("ann", back)
    now = desk.now
    assert list(now.structure.nodes.values()) == list(start.structure.nodes.values())
    np.testing.assert_array_equal(now.state.q, start.state.q)
    assert now.state.signals == start.state.signals
    assert now.state.tick == 9
    assert now.state.epoch > 1
    assert now.structure.next_uid > start.structure.next_uid
    assert now.state.running_sensors.keys() == start.state.running_sensors.keys()
    assert now.state.sensor_starts > start.state.sensor_starts


def test_a_restore_stands_between_undo_and_what_was_before_it(desk: Desk) -> None:
    start = desk.now
    made = desk.do("ann", commands.CreateNodes((part("box", shifted()),)))
    desk.do("ann", commands.RemoveNode("box"))
    desk.undo()
    desk.do("bob", checkpoint_of(start, "noon"))
    for undo in (desk.undo, desk.redo):
        for mine in (None, ann):
            with pytest.raises(KernelError, match=r"since step 4 .*stands in between.*'before step 4'"):
                undo(mine=mine)
    with pytest.raises(Conflict) as conflict:
        desk.undo(number=made.number)
    told = desk.steps.conflict(made, conflict.value)
    assert "by step 4 of bob" in str(told) and told.metadata["step"] == "4"
    desk.do("ann", moved(1.0))
    desk.undo()
    assert desk.x() != 1.0


def test_a_search_does_not_decode_what_steps_have_changed() -> None:
    """That is most of a history: a search of 64 MB for somebody who never was there took longer than 20 s."""

    class Unread:
        def decode(self, data: bytes) -> object:
            raise AssertionError("a difference was decoded")

    desk = Desk()
    desk.do("ann", commands.CreateNodes((NodeSpec("shelf", Kind.OBJECT),)))
    assert desk.store.step(1)
    kept = StoredSteps(desk.store, Unread())  # pyright: ignore[reportArgumentType] of its methods one is called
    assert not list(kept.find(Wanted(author="nobody")))


def test_who_stands_in_the_way_is_looked_for_from_the_newest_on(desk: Desk) -> None:
    """Among those that are about the same node.

    A conflict with a step of long ago read all steps since, one list of them: half a minute of a long history.
    """
    desk.do("ann", moved(1.0))
    for number in range(20):
        desk.do("bob", commands.CreateNodes((NodeSpec(f"shelf {number}", Kind.OBJECT),)))
    desk.do("bob", moved(2.0))
    for number in range(20):
        desk.do("bob", commands.CreateNodes((NodeSpec(f"box {number}", Kind.OBJECT),)))
    step = desk.steps.to_undo(1)
    with pytest.raises(Conflict) as error:
        after(desk.now, taking_back(step))
    codec, read = world_codec(), []

    class Counted:
        def decode(self, data: bytes) -> object:
            read.append(data)
            return codec.decode(data)

    kept = StoredSteps(desk.store, Counted())  # pyright: ignore[reportArgumentType] of its methods one is called
    counting = Steps(kept)
    assert kept.last == 42 and len(counting.since(1)) == 42 and not read
    assert counting.conflict(step, error.value).metadata["step"] == "22"
    assert len(read) == 1


def test_steps_in_memory_say_what_the_store_says(
    desk: Desk, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The newest ones stay there; some were drawn out."""
    monkeypatch.setattr(stored_steps, "MOST_RECENT", 12)
    for _ in range(24):
        if rng.random() < 0.5 and "table" in desk.now.structure.uid_by_name:
            desk.do("ann", moved(rng.uniform()), seconds=0.1)
        else:
            desk.do("bob", *random_batch(rng, desk.now))
        written = StoredSteps(desk.store, world_codec())
        for wanted in (Wanted(), Wanted(kinds=frozenset({StepKind.EDIT}), node="table"), Wanted(author="bob")):
            for before in (None, desk.number - 2):
                found = [[said(one) for one in islice(kept.find(wanted, before), 8)] for kept in (desk.kept, written)]
                assert found[0] == found[1]
    for number in range(1, desk.number + 2):
        found = [one and said(one) for one in (desk.kept.get(number), written.get(number))]
        assert found[0] == found[1]


def said(step: Step) -> tuple[object, ...]:
    """Return what a step says, its difference as bytes."""
    changed = world_codec().encode((step.difference.old, step.difference.new))
    return step.number, step.first_number, step.label, step.author, step.kind, step.touched, step.names, changed
