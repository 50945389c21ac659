"""Criteria that tell the branches of an arm apart, from its geometry: shoulder, elbow and wrist, and their names.

With u the direction of axis 1 that points up, h_i the direction of axis i, p_i a point on it, W the wrist's centre and
E what the elbow carries (W, or axis 4 where it is parallel to axes 2 and 3), the arm is singular where one of these is
zero, and each has one sign in between (the factors of the Jacobian's determinant; C. S. G. Lee and M. Ziegler,
Geometric approach in solving inverse kinematics of PUMA robots, IEEE Trans. Aerospace and Electronic Systems 20(6),
1984):

    shoulder  s = (u x (W - p_1)) . h_2
    elbow     e = ((p_3 - p_2) x (E - p_3)) . h_2
    wrist     w = (h_4 x h_5) . h_6
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.closed_form.geometry import ANGLE, LENGTH, Axes

ELBOW = ("up", "down")
WRIST = ("noflip", "flip")


class Scheme(NamedTuple):
    """Criteria that tell the branches of one arm apart; `words` is empty where they have no names."""

    words: tuple[tuple[str, str], ...]
    """For each of shoulder, elbow, wrist that the arm has: the word for the positive side and for the other."""
    wrist_frame: int
    """The joint (from 0) on whose axis W lies; n for the tip itself."""
    wrist_shift: float
    """W's place on that axis (m)."""
    elbow_frame: int
    """The joint on whose axis E lies; n for the tip itself."""
    elbow_shift: float
    up: float
    """1 or -1: u is this times h_1."""
    shoulder_sign: float
    """1 or -1: times s it is positive on the side of the first word."""
    wrist_sign: float
    """1 or -1, the same for w; 0 where the arm has no such wrist."""
    lateral: float
    """(W - p_1) . h_2 (m), which never changes."""
    is_parallel: bool
    """True where axes 2, 3 and 4 are parallel."""


NAMELESS = Scheme((), 0, 0.0, 0, 0.0, 1.0, 1.0, 0.0, 0.0, False)


def scheme_of(axes: Axes) -> Scheme:
    """Return how the branches of an arm are told apart.

    Its axis 2 must be at a right angle to axis 1 and parallel to axis 3; six axes need a wrist whose last two meet.
    """
    h, p, n = axes.direction, axes.point, len(axes.direction)
    if n < 3 or n == 4 or abs(h[0] @ h[1]) > ANGLE or not _parallel(h[1], h[2]):
        return NAMELESS
    is_parallel = n > 4 and _parallel(h[2], h[3])
    wrist = _wrist(axes, is_parallel)
    if wrist is None:
        return NAMELESS
    frame, shift = wrist
    centre = axes.base_t_tip[:3, 3] if frame == n else p[frame] + shift * h[frame]
    up = -1.0 if h[0, 2] < -0.1 else 1.0
    s = np.cross(up * h[0], centre - p[0]) @ h[1]
    lateral = float((centre - p[0]) @ h[1])
    forward = np.cross(up * h[0], p[1] - p[0]) @ h[1]
    words, reference = ("front", "back"), s
    if abs(forward) > LENGTH:
        reference = forward
    elif abs(lateral) > LENGTH:
        words, reference = ("left", "right"), lateral
    signs = [words, ELBOW]
    wrist_sign = 0.0
    if n == 6:
        signs.append(WRIST)
        wrist_sign = _wrist_sign(h)
    elbow = (3, 0.0) if is_parallel else wrist
    return Scheme(
        tuple(signs),
        *wrist,
        *elbow,
        up,
        -1.0 if reference < -LENGTH else 1.0,
        wrist_sign,
        lateral,
        is_parallel and n == 6,
    )


def branch_names(scheme: Scheme) -> tuple[str, ...]:
    """Return the names of all branches in their order: bit 0 of a branch's number is the last word's."""
    return tuple(" ".join(words) for words in product(*scheme.words)) if scheme.words else ("",)


def turn_words(joint_names: Sequence[str], turns: Sequence[int]) -> str:
    """Return what is added to a branch's name for joints that are full turns away: ` joint_6+1`, or nothing."""
    return "".join(f" {name}{turn:+d}" for name, turn in zip(joint_names, turns, strict=True) if turn)


def check_configuration(configuration: str, scheme: Scheme, joint_names: Sequence[str]) -> None:
    """Raise ArgumentError unless this is the name of a branch, with or without full turns."""
    if not scheme.words:
        raise ArgumentError(
            f"the configuration {configuration!r} cannot be told: the branches of this arm have no names; without a "
            "configuration the branch nearest to the seed is taken, of a move the one nearest to its start",
            configuration=configuration,
        )
    names = branch_names(scheme)
    branch = next((name for name in names if configuration == name or configuration.startswith(f"{name} ")), None)
    if branch is not None:
        rest = configuration[len(branch) :]
        for name in joint_names:
            rest = re.sub(rf"^ {re.escape(name)}[+-][1-9]\d*(?= |$)", "", rest)
        if not rest:
            return
    raise ArgumentError(
        f"there is no configuration {configuration!r}; there are {', '.join(map(repr, names))}, each also with full "
        f"turns of joints as in {names[0] + turn_words(joint_names[-1:], (1,))!r}",
        configuration=configuration,
        valid=", ".join(names),
    )


def _wrist(axes: Axes, is_parallel: bool) -> tuple[int, float] | None:
    """Return the joint on whose axis the wrist's centre lies, and its place there (m); None without such a centre."""
    n = len(axes.direction)
    if n == 3:
        return n, 0.0
    if n == 5 and is_parallel:
        return 3, 0.0
    shift = _meeting(axes, n - 1, n - 2)
    return None if shift is None else (n - 1, shift)


def _meeting(axes: Axes, i: int, j: int) -> float | None:
    """Return the place on axis i (m) where axis j meets it; None where they don't meet."""
    a, b = axes.direction[i], axes.direction[j]
    between = axes.point[j] - axes.point[i]
    normal = np.cross(a, b)
    square = float(normal @ normal)
    if square < ANGLE**2 or abs(between @ normal) / math.sqrt(square) > LENGTH:
        return None
    return float(np.cross(between, b) @ normal / square)


def _parallel(a: Floats, b: Floats) -> bool:
    return float(np.linalg.norm(np.cross(a, b))) < ANGLE


def _wrist_sign(h: Floats) -> float:
    """Return the sign of dw / dq_5 at the straight wrist that is nearest to q_5 = 0.

    w = a sin(q_5) + b cos(q_5), since h_4 x h_5 is at a right angle to axis 5.
    """
    normal = np.cross(h[3], h[4])
    a = float(normal @ np.cross(h[4], h[5]))
    b = float(normal @ h[5])
    straight = math.atan2(-b, a)
    if straight > math.pi / 2 + 1e-9:
        straight -= math.pi
    elif straight < -math.pi / 2 + 1e-9:
        straight += math.pi
    return 1.0 if a * math.cos(straight) - b * math.sin(straight) > 0.0 else -1.0
