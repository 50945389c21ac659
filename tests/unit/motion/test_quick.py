"""Records made in a quarter of the time are those of the constructor: all fields, frozen, replaced and kept alike."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace

import pytest
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.quick import changer, maker
from virtualrobot_kernel.world.state import Motion, State


@dataclass(frozen=True, slots=True)
class Point:
    """A point with a name."""

    x: float
    y: float = 2.0
    names: tuple[str, ...] = field(default=("a",))

    @property
    def sum(self) -> float:
        return self.x + self.y


def test_it_is_what_the_constructor_makes() -> None:
    made, built = maker(Point)(1.0, 2.0, ("a",)), Point(1.0)
    assert type(made) is Point and isinstance(made, Point)
    assert made == built and hash(made) == hash(built) and repr(made) == repr(built)
    assert made.sum == 3.0
    assert replace(made, x=5.0) == Point(5.0)
    assert pickle.loads(pickle.dumps(made)) == built


def test_it_is_frozen() -> None:
    made = maker(Point)(1.0, 2.0, ())
    with pytest.raises(FrozenInstanceError):
        made.x = 3.0  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        del made.x  # type: ignore[misc]


@pytest.mark.parametrize("of", [PlanExecution, ProgramRun, Motion, State])
def test_each_field_of_what_ticks_make_gets_its_own_value(of: type) -> None:
    values = [object() for _ in fields(of)]
    made, built = maker(of)(*values), of(*values)
    for one, value in zip(fields(of), values, strict=True):
        assert getattr(made, one.name) is getattr(built, one.name) is value
    with pytest.raises(TypeError):
        maker(of)(*values[1:])


@pytest.mark.parametrize("of", [PlanExecution, ProgramRun, Motion, State])
def test_what_is_changed_is_what_replace_makes(of: type) -> None:
    one, other = of(*(object() for _ in fields(of))), object()
    for changed in fields(of):
        made, replaced = changer(of, changed.name)(one, other), replace(one, **{changed.name: other})
        assert type(made) is of
        assert all(getattr(made, field.name) is getattr(replaced, field.name) for field in fields(of))
    both = changer(Point, "names", "x")(Point(1.0), (), 3.0)
    assert both == Point(3.0, 2.0, ())


def test_a_field_that_is_none_is_refused() -> None:
    with pytest.raises(TypeError, match="Point has no field 'z'; it has x, y, names"):
        changer(Point, "x", "z")


def test_a_class_whose_constructor_does_more_is_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Checked:
        x: float

        def __post_init__(self) -> None:
            assert self.x > 0.0

    @dataclass(frozen=True)
    class Open:
        x: float

    for of in (Checked, Open, int):
        with pytest.raises(TypeError, match="no dataclass with slots whose constructor only sets its fields"):
            maker(of)
