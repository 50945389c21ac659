"""Goal of a robot, as the commands `move`, `plan` and `check` take it."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from virtualrobot.cli.names import GROUP, LINK, NODE, ROBOT, TARGET
from virtualrobot.cli.options import Numbers, degrees_option, pose_of_numbers

if TYPE_CHECKING:
    from virtualrobot.motions.moves import Move
    from virtualrobot.robots.group import Group
    from virtualrobot.robots.robot import Robot


Part = tuple[str, str, str]
"""A group of a robot by name, or the base and tip link of a chain; all empty: the robot itself."""


@dataclass(frozen=True, slots=True)
class Order:
    """Goal as the command line gives it; one of joints, pose, place, a posture or target, and trajectory is given."""

    joints: tuple[str, ...]
    pose: tuple[float, ...] | None
    place: str
    above: float | None
    reference: str | None
    linear: bool
    via: tuple[float, ...] | None
    speed: float
    velocity: float | None
    degrees: bool
    group: Part
    trajectory: Path | None

    def move(self, whole: Robot) -> Move:
        """Return the move that these words mean for a robot, or its group."""
        robot = part_of(whole, self.group)
        if self.trajectory is not None:
            return robot.read_trajectory(self.trajectory, speed_factor=self.speed)
        if self.place and self.linear:
            return robot.linear(self.place, above=self.above, velocity=self.velocity, speed_factor=self.speed)
        if self.place:
            return robot.ptp(self.place, above=self.above, speed_factor=self.speed)
        if self.pose is None:
            return robot.ptp(joint_goal(robot, self.joints, self.degrees), speed_factor=self.speed)
        where = pose_of_numbers(self.pose, self.degrees, robot.tcp if not self.reference else None)
        if self.via is None and not self.linear:
            return robot.ptp(where, reference=self.reference, speed_factor=self.speed)
        if self.via is None:
            return robot.linear(where, reference=self.reference, velocity=self.velocity, speed_factor=self.speed)
        return robot.circular(
            self.via, where, reference=self.reference, velocity=self.velocity, speed_factor=self.speed
        )


def part_of(robot: Robot, group: Part) -> Robot | Group:
    """Return a robot, or its group that the command line names."""
    name, base, tip = group
    return robot.group(name or None, base=base or None, tip=tip or None) if any(group) else robot


def group_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that choose a part of a robot, as `group`."""

    @click.option("--group", "name", type=GROUP, metavar="NAME", help="The robot's group that moves, such as left_arm.")
    @click.option("--base", type=LINK, metavar="LINK", help="Instead: the chain that begins at this link [the base].")
    @click.option("--tip", type=LINK, metavar="LINK", help="And ends at this one [the flange].")
    @functools.wraps(function)
    def command(*arguments: Any, name: str | None, base: str | None, tip: str | None, **options: Any) -> Any:  # noqa: ANN401
        if name and (base or tip):
            raise click.UsageError("name a --group, or the links --base and --tip, not both")
        return function(*arguments, group=(name or "", base or "", tip or ""), **options)

    return command


def order_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the arguments that say where a robot shall go, as `robot` and `order`."""

    @click.argument("robot", type=ROBOT)
    @click.argument("more", nargs=-1, metavar="[JOINT=VALUE]...")
    @click.option("--joints", metavar="VALUES", help="JOINT=VALUE,... or all values in order: 0,0.5,0,-1.2,0,0.8,0")
    @click.option("--pose", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where the tool centre point goes.")
    @click.option("--to", "place", type=TARGET, metavar="NAME", help="A posture, such as home, or a target.")
    @click.option("--above", type=float, metavar="METERS", help="With --to a target: back from it, along its own z.")
    @click.option("--trajectory", type=click.Path(dir_okay=False, path_type=Path), help="Through a CSV or JSON file.")
    @click.option("--reference", type=NODE, help="The node in whose frame the pose is given [world].")
    @click.option("--linear", is_flag=True, help="Along a straight line; with --pose or a target.")
    @click.option("--via", type=Numbers(3), metavar="X,Y,Z", help="Along an arc through this point; with --pose.")
    @click.option("--speed", type=float, default=1.0, help="The part of the greatest joint speed, in (0, 1] [1].")
    @click.option("--velocity", type=float, metavar="M/S", help="With --linear or --via: along the path [0.25].")
    @group_options
    @degrees_option
    @functools.wraps(function)
    def command(
        *arguments: Any,  # noqa: ANN401 those of the command
        more: tuple[str, ...],
        joints: str | None,
        pose: tuple[float, ...] | None,
        place: str | None,
        above: float | None,
        reference: str | None,
        linear: bool,
        via: tuple[float, ...] | None,
        speed: float,
        velocity: float | None,
        degrees: bool,
        group: Part,
        trajectory: Path | None,
        **options: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        words = tuple(word for word in (joints, *more) if word)
        if bool(words) + (pose is not None) + bool(place) + (trajectory is not None) != 1:
            raise click.UsageError("say where to, in one way: --joints, --pose, --to or --trajectory")
        if linear and pose is None and not place:
            raise click.UsageError("--linear goes with --pose, or with --to a target")
        if above is not None and not place:
            raise click.UsageError("--above goes with --to a target")
        if via is not None and (pose is None or linear):
            raise click.UsageError("--via goes with --pose and without --linear")
        if not 0 < speed <= 1:
            raise click.UsageError(f"--speed is above 0, up to 1, not {speed:g}")
        if velocity is not None and not linear and via is None:
            raise click.UsageError("--velocity goes with --linear or --via; other moves take --speed")
        if velocity is not None and not velocity > 0:
            raise click.UsageError(f"--velocity is above 0, not {velocity:g}")
        goal = (words, pose, place or "", above or None, reference, linear, via)
        order = Order(*goal, speed, velocity, degrees, group, trajectory)
        return function(*arguments, order=order, **options)

    return command


TURNING = ("revolute", "continuous")
"""Types of joints that turn about an axis."""


def joint_goal(robot: Robot | Group, words: Sequence[str], degrees: bool) -> dict[str, float] | list[float]:
    """Return joint values by name from `name=value` words, or in order from numbers; `degrees` for turning joints."""
    from virtualrobot.errors import UnknownNameError

    entries = [entry for word in words for entry in re.split(r"[\s,]+", word.strip(" ,"))]
    named = ["=" in entry for entry in entries]
    if any(named) and not all(named):
        raise click.UsageError("give joint values either all by name or all in order")
    try:
        values = [float(entry.rpartition("=")[2]) for entry in entries]
    except ValueError:
        raise click.UsageError(f"{' '.join(words)!r} are no joint values: name=value,... or numbers") from None
    names = [entry.rpartition("=")[0] for entry in entries]
    if all(named) and (twice := next((name for name in names if names.count(name) > 1), None)):
        raise click.UsageError(f"the joint {twice!r} is given twice")
    if not degrees:
        return dict(zip(names, values, strict=True)) if all(named) else values
    turning, every = angles(robot), list(robot.coordinates)
    if all(named):
        if unknown := sorted(set(names) - set(every)):
            raise UnknownNameError(f"the robot {robot.name!r} has no joint {unknown[0]!r}; it has {', '.join(every)}")
    else:
        chain = robot.chain_joint_names
        names = every if len(values) == len(every) else chain
        if len(names) != len(values):
            return values  # the robot says what is wrong
    return {n: math.radians(v) if n in turning else v for n, v in zip(names, values, strict=True)}


def angles(robot: Robot | Group) -> set[str]:
    """Return the names of the coordinates that are angles, and no meters or parts of a quaternion."""
    types = robot.joint_types
    return {name for name, joint in robot.coordinates.items() if types[joint] in TURNING or name.endswith("/theta")}
