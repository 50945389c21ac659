"""Steps of programs: their options, the places of patterns, and how robots are named in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Protocol, TypeAlias, TypedDict, TypeVar, runtime_checkable

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import pose_message, value_or_default, vector_message
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions.moves import pose_goal
from virtualrobot.robots.redundancy import Prefer, redundancy
from virtualrobot.v1 import motion_pb2


@runtime_checkable
class HasName(Protocol):
    """Something with a name, such as a robot."""

    @property
    def name(self) -> str:
        """Its name."""
        ...


Named: TypeAlias = Annotated[str | HasName, "a robot or its name"]
"""A robot, or its name."""


NodeNamed: TypeAlias = Annotated[str | HasName, "a node, its name (not empty)"]
"""A node, such as a tool, or its name."""


class AtOptions(TypedDict, total=False):
    """Options of steps that go somewhere and handle a part there.

    Attributes:
        approach: length of the line to the goal, along -z of the goal (m); none by default.
        retreat: length of the line away from it (m); that of the approach by default.
        state_before: the state in which the tool comes; as it is by default.
        state: the state of the tool in which it holds the part, or lets go.
        width_before: instead of `state_before`, how wide it is open then (m).
        width: instead of `state`, how wide it is open then (m).
        reference: the node in whose frame the goal is given.
        configuration: the only configuration that will do, as of `Robot.ptp`.
        speed_factor: as of any move.
        velocity: the greatest speed on the lines (m/s), 0.25 by default.
        acceleration: the greatest acceleration on the lines (m/s^2), 1 by default.
        prefer: what joints that the goal doesn't need are used for on the way there, as of `Robot.ptp`.
        arm_angle: as of `Robot.ptp`.
    """

    approach: float | None
    retreat: float | None
    state_before: str | None
    state: str | None
    width_before: float | None
    width: float | None
    reference: str | None
    configuration: str | None
    speed_factor: float | None
    velocity: float | None
    acceleration: float | None
    prefer: Prefer | None
    arm_angle: float | None


class PickAtOptions(AtOptions, total=False):
    """Options of picks.

    Attributes:
        max_distance: the greatest distance of the part's origin from the tool centre point (m), as of `Robot.pick`.
    """

    max_distance: float | None


class PlaceAtOptions(AtOptions, total=False):
    """Options of places.

    Attributes:
        parent: the new parent of the part; `world` by default.
    """

    parent: str | None


@checked
@dataclass(frozen=True, slots=True)
class Pattern:
    """Places in columns along x, rows along y and layers along z of a frame, as on a pallet; in meters and radians.

    The frame of the first layer is in its middle: the place in column c and row r of layer k, all from 0, is at
    x = (c - (columns - 1) / 2) column_pitch, y = (r - (rows - 1) / 2) row_pitch, z = k layer_pitch.

    Attributes:
        columns: number of places along x.
        rows: number of places along y.
        layers: number of layers.
        column_pitch: distance of columns (m).
        row_pitch: distance of rows (m).
        layer_pitch: distance of layers (m).
        pose: 4x4 pose of the pattern's frame in that of the reference; the reference itself by default.
        layer_turn: turn of every second layer with its places about z (rad).
        layer_offset: (3,) shift of every second layer (m).
        order: `column by column`, `row by row`, `columns to and fro` or `rows to and fro`.
    """

    columns: int
    rows: int
    layers: int = 1
    column_pitch: float = 0.0
    row_pitch: float = 0.0
    layer_pitch: float = 0.0
    pose: PoseLike | None = None
    layer_turn: float = 0.0
    layer_offset: ArrayLike = (0.0, 0.0, 0.0)
    order: str = "column by column"

    @property
    def _message(self) -> motion_pb2.Pattern:
        name = "PATTERN_ORDER_" + self.order.replace(" ", "_").upper()
        if name not in motion_pb2.PatternOrder.keys():
            names = motion_pb2.PatternOrder.keys()[1:]
            orders = (repr(one.removeprefix("PATTERN_ORDER_").replace("_", " ").lower()) for one in names)
            raise InvalidArgumentError(f"order is {self.order!r}; give one of {', '.join(orders)}")
        return motion_pb2.Pattern(
            columns=self.columns,
            rows=self.rows,
            layers=self.layers,
            column_pitch_meters=self.column_pitch,
            row_pitch_meters=self.row_pitch,
            layer_pitch_meters=self.layer_pitch,
            reference_t_pattern=None if self.pose is None else pose_message(self.pose),
            layer_turn_radians=self.layer_turn,
            layer_offset=vector_message(self.layer_offset, "the layer's offset"),
            order=name,
        )


def name_of(robot: Named) -> str:
    """Return the name of a robot."""
    return robot if isinstance(robot, str) else robot.name


Handled = TypeVar("Handled", motion_pb2.PickAtStep, motion_pb2.PlaceAtStep)


def handled(step: Handled, robot: Named, goal: PoseLike, options: AtOptions) -> Handled:
    """Return a step of going somewhere and handling a part there, with what both kinds have."""
    approach = options.get("approach") or 0.0
    retreat = options.get("retreat")
    step.robot = name_of(robot)
    step.goal.CopyFrom(pose_goal(goal, options))
    step.approach_meters = approach
    step.retreat_meters = approach if retreat is None else retreat
    step.state_before = options.get("state_before") or ""
    step.state = options.get("state") or ""
    if (width := options.get("width_before")) is not None:
        step.width_before_meters = width
    if (width := options.get("width")) is not None:
        step.width_meters = width
    step.speed_factor = value_or_default(options.get("speed_factor"), "speed_factor")
    step.max_velocity_meters_per_second = value_or_default(options.get("velocity"), "velocity")
    step.max_acceleration_meters_per_second_squared = value_or_default(options.get("acceleration"), "acceleration")
    wish = redundancy(prefer=options.get("prefer"), arm_angle=options.get("arm_angle"), joints_now=dict)
    if wish is not None:
        step.redundancy.CopyFrom(wish)
    return step
