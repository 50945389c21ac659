"""Descriptions of nodes are kept, within their bounds; locked nodes stay as they are."""

from __future__ import annotations

import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.about import About
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import AttachNode, Command, CreateNodes, RemoveNode, UpdateNode
from virtualrobot_kernel.world.difference import difference
from virtualrobot_kernel.world.history_commands import RestoreRecords
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.world.builders import after, empty, shifted, world_t


@pytest.fixture
def cell() -> Change:
    return after(
        empty(),
        CreateNodes(
            (
                NodeSpec("table", Kind.OBJECT),
                NodeSpec("box", Kind.PART, "table", about=About("waits", ("stock",), locked=True)),
                NodeSpec("shelf", Kind.OBJECT),
            )
        ),
    )


def about(change: Change, name: str) -> About | None:
    return change.structure.node(name).about


def test_each_field_is_said_by_itself(cell: Change) -> None:
    said = after(cell, UpdateNode("table", description="of oak"), UpdateNode("table", tags=("fixture", "wood")))
    assert about(said, "table") == About("of oak", ("fixture", "wood"))
    assert about(after(said, UpdateNode("table", tags=())), "table") == About("of oak")
    assert about(after(said, UpdateNode("table", tags=(), description="")), "table") is None
    told = difference(cell, said)
    assert dict(told.old.about) == {cell.structure.node("table").uid: None}
    back = after(said, RestoreRecords(restored=told.old, found=told.new))
    assert about(back, "table") is None
    assert about(after(back, RestoreRecords(restored=told.new, found=told.old)), "table") == about(said, "table")
    others = after(said, UpdateNode("table", description="of ash"))
    with pytest.raises(KernelError, match="what is said of 'table' has been changed since"):
        after(others, RestoreRecords(restored=told.old, found=told.new))


@pytest.mark.parametrize(
    "command",
    [
        UpdateNode("box", new_name="case"),
        UpdateNode("box", parent_t_node=shifted(x=1.0)),
        UpdateNode("box", figures=()),
        AttachNode("box", "shelf"),
        RemoveNode("box"),
        RemoveNode("table"),
    ],
)
def test_what_is_locked_stays(cell: Change, command: Command) -> None:
    with pytest.raises(KernelError, match="'box' is locked; unlock it") as refusal:
        after(cell, command)
    assert refusal.value.reason is Reason.WRONG_STATE
    after(cell, UpdateNode("box", locked=False), command)


def test_what_is_locked_goes_along_and_is_hidden_and_described(cell: Change) -> None:
    moved = after(cell, UpdateNode("table", parent_t_node=shifted(x=0.5)), UpdateNode("box", hidden=True, tags=("a",)))
    assert world_t(moved, "box")[0, 3] == 0.5
    assert about(moved, "box") == About("waits", ("a",), locked=True)
    unlocked = after(cell, UpdateNode("box", locked=False, new_name="case"))
    assert about(unlocked, "case") == About("waits", ("stock",))


@pytest.mark.parametrize(
    ("said", "named"),
    [
        ({"description": "x" * 2001}, "description has 2001 characters"),
        ({"icon": "x" * 65}, "icon has 65 characters"),
        ({"tags": ("a", "b", "a")}, r"tags\[2\] is 'a' again"),
        ({"tags": (" a",)}, r"tags\[0\] is ' a'"),
        ({"tags": ("",)}, r"tags\[0\] is ''"),
        ({"tags": tuple(map(str, range(33)))}, "tags are 33; at most 32"),
    ],
)
def test_words_that_are_none_are_refused(cell: Change, said: dict, named: str) -> None:
    with pytest.raises(KernelError, match=named):
        after(cell, UpdateNode("table", **said))
    with pytest.raises(KernelError, match=named):
        after(cell, CreateNodes((NodeSpec("new", Kind.OBJECT, about=About(**said)),)))
