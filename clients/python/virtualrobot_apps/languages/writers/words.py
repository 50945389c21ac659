"""Words and numbers that all writers share: names, numbers without noise, angles, and where signals are."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix

from virtualrobot_apps.languages.writers.statements import RobotProgram, every, signal_of


@dataclass(frozen=True, slots=True)
class Language:
    """Facts about the controller that a writer needs beside the program.

    Attributes:
        signals: where each signal is on the controller, such as `DO[3]`, by its name here.
        signs: by what the joints' angles here are multiplied to be the controller's.
        coupling: by what part of joint 2 the controller's angle of joint 3 is less than here, as FANUC counts it.
    """

    signals: Mapping[str, str]
    signs: tuple[float, ...] = ()
    coupling: float = 1.0


def number(value: float, digits: int = 12) -> str:
    """Return a number in as few digits as tell it, to 1e-9."""
    rounded = round(float(value), 9)
    return f"{rounded + 0.0:.{digits}g}"


def names_for(names: Iterable[str], longest: int, taken: Iterable[str] = ()) -> dict[str, str]:
    """Return a name for each one of letters, digits and underscores, which begins with a letter, none twice."""
    used = {one.lower() for one in taken}
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII) or "_"
        base = (plain if plain[0].isalpha() else f"n{plain}")[:longest]
        wanted, count = base, 1
        while wanted.lower() in used:
            count += 1
            wanted = f"{base[: longest - len(str(count)) - 1]}_{count}"
        used.add(wanted.lower())
        found[name] = wanted
    return found


def addresses(program: RobotProgram, language: Language, pattern: str, example: str) -> dict[str, str]:
    """Return where the signals of a program are; raises InvalidArgumentError for one that is nowhere, or wrong."""
    found: dict[str, str] = {}
    for at, statement in every(program.statements):
        name = signal_of(statement)
        if name is None:
            continue
        where = language.signals.get(name)
        if where is None:
            raise InvalidArgumentError(
                f"step {at}: the signal {name!r} has no address on the controller; give --signal {name}={example}"
            )
        if not re.fullmatch(pattern, where):
            raise InvalidArgumentError(f"the signal {name!r} can't be at {where!r}; an address is as {example}")
        found[name] = where
    return found


def zyx_degrees(matrix: Matrix) -> tuple[float, float, float]:
    """Return the turns about z, then y, then x (degrees) of a 4x4 pose: KUKA's A, B, C, and FANUC's R, P, W."""
    m = np.asarray(matrix)
    if abs(m[2, 0]) > 1.0 - 1e-12:  # y points along z: the turns about z and x are one, told as the one about z
        about_z, about_x = math.atan2(-m[0, 1], m[1, 1]), 0.0
    else:
        about_z, about_x = math.atan2(m[1, 0], m[0, 0]), math.atan2(m[2, 1], m[2, 2])
    about_y = math.atan2(-m[2, 0], math.hypot(m[2, 1], m[2, 2]))
    return math.degrees(about_z), math.degrees(about_y), math.degrees(about_x)


def said(where: str, what: str, language: str) -> InvalidArgumentError:
    """Return the error of a step that a language can't tell."""
    return InvalidArgumentError(f"step {where}: {what} can't be said in {language}")


def six_joints(program: RobotProgram, language: str) -> None:
    """Raise InvalidArgumentError for an arm that has not six turning joints."""
    if len(program.joint_names) != 6 or any(program.prismatic):
        count = len(program.joint_names)
        raise InvalidArgumentError(
            f"{program.robot!r} has {count} joints; {language} is written for arms with six that turn"
        )
