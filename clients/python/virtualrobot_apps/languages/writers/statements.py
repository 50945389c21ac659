"""Statements of one robot's program, whatever language it will be written in: moves, signals, waits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import Matrix

Floats = NDArray[np.float64]
Value: TypeAlias = bool | int | float


@dataclass(frozen=True, slots=True)
class Zone:
    """Corner after a move that is rounded off: its radius (m), and the share of the moves' lengths, up to 0.5."""

    meters: float
    share: float


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """Place where a move ends.

    Attributes:
        joints: (n,), rad or m.
        base_t_tcp: 4x4 pose of the tool centre point in the frame of the robot's base.
        frame: the frame in which the pose was given, by name; empty: that of the base.
        frame_t_tcp: 4x4, the pose in that frame.
        branch: the posture by the name of its branch, such as `front up noflip`; empty: joints were given, or none has
            a name.
    """

    joints: Floats
    base_t_tcp: Matrix
    frame: str = ""
    frame_t_tcp: Matrix | None = None
    branch: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class PointToPoint:
    """Joints that all go evenly to a goal.

    Attributes:
        goal: the goal.
        share: the part of the joints' greatest speed.
        speed: the greatest speed of the tool centre point on the way (m/s), and `turning` how fast it turns (rad/s),
            at that share and without accelerations.
        acceleration: the greatest acceleration of the joint that has the longest way, by its speed (rad/s^2), and
            `leading` its speed at that share (rad/s).
        zone: the corner with the next move; None: it stands there.
    """

    goal: Goal
    share: float
    speed: float
    turning: float
    leading: float
    acceleration: float
    zone: Zone | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """Tool centre point that goes along a line, at a speed (m/s) with an acceleration (m/s^2)."""

    goal: Goal
    speed: float
    acceleration: float
    zone: Zone | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """Tool centre point that goes along an arc through a place in the middle of it; otherwise as `Line`."""

    goal: Goal
    via: Goal
    speed: float
    acceleration: float
    zone: Zone | None = None


@dataclass(frozen=True, slots=True)
class UseTool:
    """Tool that is another one from here on, by its name in `RobotProgram.tools`."""

    tool: str


@dataclass(frozen=True, slots=True)
class SetSignal:
    """Signal that gets a value."""

    signal: str
    value: Value


@dataclass(frozen=True, slots=True)
class Condition:
    """Condition that a signal compares so with a value: `==`, `!=`, `<`, `<=`, `>` or `>=`."""

    signal: str
    comparison: str
    value: Value


@dataclass(frozen=True, slots=True)
class WaitSignal(Condition):
    """Wait until a condition holds; after `seconds`, if given, it is an error."""

    seconds: float | None


@dataclass(frozen=True, slots=True, eq=False)
class If:
    """Statements that are done if a condition holds where the robot stands then, and those that are done otherwise."""

    condition: Condition
    then: tuple[Placed, ...]
    otherwise: tuple[Placed, ...]


@dataclass(frozen=True, slots=True, eq=False)
class While:
    """Statements that are done again and again while a condition holds before each round; None: for ever."""

    condition: Condition | None
    body: tuple[Placed, ...]


@dataclass(frozen=True, slots=True)
class Dwell:
    """Wait of some seconds."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Comment:
    """Words for people: what the program does in the simulator's world alone."""

    text: str


Move: TypeAlias = PointToPoint | Line | Arc
Statement: TypeAlias = Move | UseTool | SetSignal | WaitSignal | Dwell | Comment | If | While
Placed: TypeAlias = tuple[str, Statement]
"""Statement with its step's place in the text, such as `4[2].0`."""


def every(statements: Iterable[Placed]) -> Iterator[Placed]:
    """Return statements and those within them."""
    for at, statement in statements:
        yield at, statement
        if isinstance(statement, If):
            yield from every((*statement.then, *statement.otherwise))
        elif isinstance(statement, While):
            yield from every(statement.body)


def signal_of(statement: Statement) -> str | None:
    """Return the signal that a statement itself sets or reads, None where it does neither."""
    if isinstance(statement, If | While):
        return statement.condition.signal if statement.condition is not None else None
    return statement.signal if isinstance(statement, SetSignal | Condition) else None


@dataclass(frozen=True, slots=True, eq=False)
class RobotProgram:
    """Program of one robot, with every place known.

    Attributes:
        name: its name, letters, digits and underscores.
        robot: the robot.
        joint_names: its joints; `prismatic` says which of them slide.
        tools: `flange_t_tcp`, 4x4, by name; the flange itself has the empty one.
        frames: `base_t_frame`, 4x4, by name; the base itself has the empty one.
        statements: what it does.
        notes: what it says otherwise than the program that it was made of.
    """

    name: str
    robot: str
    joint_names: tuple[str, ...]
    prismatic: tuple[bool, ...]
    tools: dict[str, Matrix]
    frames: dict[str, Matrix]
    statements: tuple[Placed, ...]
    notes: tuple[str, ...] = ()
