"""Unknown names: the hint is the right one, also among many, and costs little for names of any length."""

from __future__ import annotations

from virtualrobot_kernel.errors import LONGEST_NAME, UnknownNameError


def test_the_nearest_of_many_names_is_offered() -> None:
    names = [*(f"box_{i:05}" for i in range(10_000)), "gripper", *(f"part_{i:05}" for i in range(10_000))]
    assert "did you mean 'gripper'" in str(UnknownNameError("tool", "griper", names))


def test_a_name_of_any_length_is_answered() -> None:
    names = ["a" * LONGEST_NAME, "gripper"]
    assert f"did you mean '{names[0]}'" in str(UnknownNameError("tool", "a" * 1_000_000, names))


def test_names_that_are_not_near_are_not_called_near() -> None:
    assert str(UnknownNameError("robot", "x", ["arm"])) == "there is no robot named 'x'; there is 'arm'"
    many = [f"arm{i}" for i in range(10)]
    said = str(UnknownNameError("robot", "xyz", many))
    assert said.startswith("there is no robot named 'xyz'; there are 'arm0', 'arm1', ") and said.endswith(" and 2 more")
    assert str(UnknownNameError("robot", "x", [])) == "there is no robot named 'x'; there is none yet"
