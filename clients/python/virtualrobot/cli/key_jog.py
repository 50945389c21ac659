"""Jog by keys: `virtualrobot jog ARM --keys`."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

    from virtualrobot.motions.moves import Move
    from virtualrobot.robots.group import Group
    from virtualrobot.robots.robot import Robot

FRAMES = ("base", "tool", "world")
HELP = (
    "x X y Y z Z move   r R p P w W turn   1-9 choose a joint, + - move it\n"
    "[ ] smaller, larger steps   f the next frame   space stops   q ends"
)
_SMALLEST, _LARGEST = 1e-4, 0.2


@dataclass(frozen=True, slots=True)
class Jog:
    """Choices of somebody who jogs by keys: step in m (10 times as many rad), frame, and joint (from 0)."""

    step: float = 0.01
    frame: str = FRAMES[0]
    joint: int = 0

    def chosen(self, key: str) -> Jog | None:
        """Return the choices after a key; None for one that chooses nothing."""
        if key in "[]":
            step = self.step / 2.0 if key == "[" else self.step * 2.0
            return replace(self, step=min(max(step, _SMALLEST), _LARGEST))
        if key == "f":
            return replace(self, frame=FRAMES[(FRAMES.index(self.frame) + 1) % len(FRAMES)])
        return replace(self, joint=int(key) - 1) if key in "123456789" else None

    def joint_of(self, robot: Robot | Group) -> str:
        """Return the joint that is chosen, or the last one where there are not so many."""
        names = robot.chain_joint_names
        return names[min(self.joint, len(names) - 1)]

    def move(self, key: str, robot: Robot | Group) -> Move | None:
        """Return the move that a key means; None for one that moves nothing."""
        if key in "+-":
            joint = self.joint_of(robot)
            slides = robot.joint_types[joint] == "prismatic"
            distance = self.step if slides else 10.0 * self.step
            return robot.joint_jog(joint, (0.1 if slides else 0.5) * (1.0 if key == "+" else -1.0), distance)
        axis = "xyz".find(key.lower()), "rpw".find(key.lower())
        if max(axis) < 0:
            return None
        direction = [0.0, 0.0, 0.0]
        direction[max(axis)] = 1.0 if key.islower() else -1.0
        if axis[0] >= 0:
            return robot.cartesian_jog(direction, frame=self.frame, distance=self.step)
        return robot.cartesian_jog(rotation=direction, frame=self.frame, distance=10.0 * self.step)


def jog_by_keys(robot: Robot | Group, source: Input | None = None, output: Output | None = None) -> None:
    """Jog a robot by the keys of a terminal until q; each moves it by a step and takes over from the one before."""
    from virtualrobot.cli.key_screen import KeyScreen

    jog = Jog()

    def press(key: str) -> None:
        nonlocal jog
        if key == " ":
            robot.stop()
            return
        jog = jog.chosen(key) or jog
        if (move := jog.move(key, robot)) is not None:
            robot.start(move, wait=False, preempt=True)

    def text() -> str:
        x, y, z = robot.tcp[:3, 3]
        step = f"step {1000.0 * jog.step:g} mm, {math.degrees(10.0 * jog.step):.3g} deg"
        where = f"{robot.name} at {x:z.4f} {y:z.4f} {z:z.4f} m"
        return f"{HELP}\n{where}   {step}   frame {jog.frame}   joint {jog.joint_of(robot)}"

    KeyScreen(press, text).run(source, output)
    click.echo(f"{robot.name} stands where the keys have left it")
