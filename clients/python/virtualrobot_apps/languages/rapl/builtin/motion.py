"""Motion: the arm goes on while the program does, up to the next motion, FINISH, or what asks where the arm is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.languages.rapl.faults import RaplFault
from virtualrobot_apps.languages.rapl.table import command

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapl.task import RaplTask


@command("MOVE", "location [S]")
def _move(task: RaplTask, name: str, straight: str) -> None:
    """Goes to a location: all joints evenly, with S the tool on a line."""
    task.world.go(task.location(name), bool(straight))


@command("APPRO", "location number [S]")
def _approach(task: RaplTask, name: str, distance: float, straight: str) -> None:
    """Goes near a location, so far (mm) back along the tool there."""
    task.world.go(task.location(name), bool(straight), back=distance)


@command("DEPART", "number [S]")
def _depart(task: RaplTask, distance: float, straight: str) -> None:
    """Goes so far (mm) back along the tool."""
    task.world.depart(distance, bool(straight))


@command("JOG", "number number number")
def _jog(task: RaplTask, x: float, y: float, z: float) -> None:
    """Goes on a line by so far (mm) along x, y and z of the base."""
    task.world.jog(np.array([x, y, z]) / 1000.0)


@command("JOINT", "number number")
def _joint(task: RaplTask, joint: float, degrees: float) -> None:
    """Turns one joint by degrees."""
    task.world.turn(joint, np.radians(degrees))


@command("MOTOR", "number number")
def _motor(task: RaplTask, motor: float, pulses: float) -> None:
    """Turns one joint by pulses."""
    task.world.turn_pulses(motor, pulses)


@command("MA", "number...")
def _move_absolute(task: RaplTask, radians: list[float]) -> None:
    """Brings all joints to radians."""
    task.world.go_joints(task.world.checked(radians))


@command("MI", "number...")
def _move_incremental(task: RaplTask, radians: list[float]) -> None:
    """Turns all joints by radians."""
    task.world.go_joints(task.world.joints() + task.world.checked(radians))


@command("ALIGN")
def _align(task: RaplTask) -> None:
    """Turns the tool to the nearest of the axes x, y and z of the base, where it is."""
    task.world.align()


@command("READY")
def _ready(task: RaplTask) -> None:
    """Goes to the posture `home`."""
    task.world.ready()


@command("CPATH", "location...")
def _continuous_path(task: RaplTask, names: list[str]) -> None:
    """Goes through up to 16 locations, all cartesian or all points, on one smooth curve of the joints."""
    locations = [task.location(name) for name in names]
    if len(locations) > 16:
        raise RaplFault(f"CPATH takes up to 16 locations, and gets {len(locations)}")
    if len({one.is_precision for one in locations}) > 1:
        raise RaplFault("CPATH takes cartesian locations or precision points, and not both")
    task.world.through(locations)


@command("VIA", "location...")
def _via(task: RaplTask, names: list[str]) -> None:
    """Goes through locations without stopping, as CPATH does."""
    task.world.through([task.location(name) for name in names])


@command("CTPATH", "number template number number number")
def _calculate_path(task: RaplTask, path: float, template: str, first: float, last: float, speed: float) -> None:
    """Keeps a path through the locations of a template, as A001 to A009 of A, at a speed (%), for GOPATH."""
    numbers = range(int(first), int(last) + 1)
    if not numbers:
        raise RaplFault(f"the last index of CTPATH, {last:g}, is below the first, {first:g}")
    located = [task.location(f"{template}{number:03d}") for number in numbers]
    task.paths[int(path)] = (located, task.world.checked_speed(speed))


@command("GOPATH", "number")
def _go_path(task: RaplTask, number: float) -> None:
    """Goes the path of a number that CTPATH has kept."""
    if int(number) not in task.paths:
        raise RaplFault(f"there is no path {number:g}; CTPATH makes one")
    locations, speed = task.paths[int(number)]
    task.world.through(locations, speed)


@command("SPEED", "number")
def _speed(task: RaplTask, percent: float) -> None:
    """Sets the speed of moves from now on, 1 to 100 percent of the joints' speeds, and of 508 mm/s on lines."""
    task.world.speed = task.world.checked_speed(percent)


@command("FINISH")
def _finish(task: RaplTask) -> None:
    """Waits until the arm stands."""
    task.world.finish()


@command("HALT", "[ON] [signal]", signals="input")
def _halt(task: RaplTask, on: str, signal: tuple[int, bool] | None) -> None:
    """Stops the arm at once; HALT ON 3 stops moves from now on when input 3 is on (-3: off), and each is waited for."""
    if bool(on) != (signal is not None):
        raise RaplFault("it is HALT, or HALT ON with an input")
    if signal is None:
        task.world.halt()
    else:
        task.halt_on = signal


@command("ELBOW", "UP|DOWN")
def _elbow(task: RaplTask, side: str) -> None:
    """Says on which side the elbow is from now on, where a location is reached by moving the joints."""
    task.world.stance["elbow"] = side.lower()


@command("REACH", "FORWARD|BACK")
def _reach(task: RaplTask, side: str) -> None:
    """Says whether the arm reaches forward or over its head from now on."""
    task.world.stance["reach"] = {"FORWARD": "front", "BACK": "back"}[side]


@command("WRIST", "FREE|FLIP|NOFLIP")
def _wrist(task: RaplTask, side: str) -> None:
    """Says how the wrist stands from now on, of arms with six joints."""
    task.world.stance["wrist"] = "" if side == "FREE" else side.lower()


@command("OPEN", "[number]")
def _open(task: RaplTask, force: float | None) -> None:
    """Opens the gripper when the arm stands, and lets go what it holds; a force doesn't count."""
    task.world.grip(False)


@command("CLOSE", "[number]")
def _close(task: RaplTask, force: float | None) -> None:
    """Closes the gripper when the arm stands, on the part that is there; a force doesn't count."""
    task.world.grip(True)


@command("GRIP", "number")
def _grip(task: RaplTask, distance: float) -> None:
    """Opens or closes the gripper to a distance (mm) of its fingers when the arm stands."""
    task.world.grip_to(distance / 1000.0)
