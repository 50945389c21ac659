"""Records made in a quarter of the time are those of the constructor: all fields, frozen, replaced and kept alike."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace

import pytest
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.quick import maker
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
