"""Ways looked along before they are planned: where the tool gets to, and where it would touch something."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot import Client

from virtualrobot_apps.curves.way import Floats
from virtualrobot_apps.processes.leading import Leading, Wanted, touched_by
from virtualrobot_apps.processes.process import FREE, TOUCHES, UNREACHED, Look

APART = 0.01
"""Distance (m) of places that are looked at."""
MOST = 120
"""Places of all ways together: of longer ones they are farther apart."""
TURN = np.radians(30.0)
"""Angle between turns of a tool that are tried."""
COARSE = np.radians(90.0)
"""Angle between turns that are tried where the tool leans, too."""


def look_along(client: Client, leading: Leading, ways: Sequence[Wanted]) -> tuple[Look, ...]:
    """Return where the tool gets to on ways, each place for itself, in the cell as it is.

    A place is tried with the tool as it is wanted, then turned, then leaning, too, as far as tolerances go, in all
    postures, until one is found that touches nothing.
    """
    lengths = [_lengths(one.frames) for one in ways]
    apart = max(APART, sum(float(one[-1]) for one in lengths) / MOST)
    rows = [_places(one, apart) for one in lengths]
    owner = np.repeat(np.arange(len(ways)), [len(one) for one in rows])
    frames = np.concatenate([one.frames[row] for one, row in zip(ways, rows, strict=True)])
    states, why = _states(client, leading, frames, [ways[one].source.parts[0] for one in owner.tolist()])
    found = []
    for number, (one, row, at) in enumerate(zip(ways, rows, lengths, strict=True)):
        mine = np.flatnonzero(owner == number).tolist()
        world_t_part = client.scene[one.source.parts[0]].pose
        points = one.way.points @ world_t_part[:3, :3].T + world_t_part[:3, 3]
        # Frames stand off from the way, or swing about it: their places are told by the way's points beside them.
        along = np.interp(at[row] / max(float(at[-1]), 1e-12), _lengths_of(points, share=True), np.arange(len(points)))
        places = np.stack([np.interp(along, np.arange(len(points)), points[:, axis]) for axis in range(3)], axis=1)
        share = one.way.length / max(float(at[-1]), 1e-12)
        told = [states[index] for index in mine], [why[index] for index in mine]
        found.append(Look(one.name, places, at[row] * share, tuple(told[0]), tuple(told[1])))
    return tuple(found)


def _states(client: Client, leading: Leading, frames: Floats, references: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return how it is at frames (n, 4, 4) in the frames of nodes, and why, in words."""
    robot, touched = client.robot(leading.robot), touched_by(client, leading)
    states, why = [UNREACHED] * len(frames), [""] * len(frames)
    for variants in _variants(leading):
        left = [row for row, state in enumerate(states) if state != FREE]
        postures, owners, names = list[Floats](), list[int](), tuple[str, ...]()
        for row in left:
            for variant in variants:
                found = robot.solve_inverse(frames[row] @ variant, reference=references[row])
                if found.solved:
                    names = found.joint_names
                    postures.append(found.solutions)
                    owners += [row] * len(found.solutions)
                elif not why[row]:
                    why[row] = found.explanation
        if not postures:
            continue
        rows = np.concatenate(postures)
        checked = client.collisions.check_configurations(robot, rows, joint_names=names, may_touch=touched)
        for posture, row in enumerate(owners):
            pair = checked.pair(posture)
            if pair is None:
                states[row], why[row] = FREE, ""
            elif states[row] == UNREACHED:
                states[row], why[row] = TOUCHES, f"{pair[0]!r} touches {pair[1]!r}"
    return states, why


def _variants(leading: Leading) -> Iterator[list[Floats]]:
    """Yield poses (4, 4) of the tool in its frame that tolerances allow: as wanted; turned; leaning, too."""
    tolerance = leading.tolerance
    yield [np.eye(4)]
    turns = _turns(tolerance.get("rotation_z", 0.0), TURN)
    yield [_turned(0.0, 0.0, turn) for turn in turns]
    leans = [_both(tolerance.get(name, 0.0)) for name in ("rotation_x", "rotation_y")]
    coarse = [0.0, *_turns(tolerance.get("rotation_z", 0.0), COARSE)]
    yield [_turned(x, y, turn) for x in leans[0] for y in leans[1] if x or y for turn in coarse]


def _turns(allowed: float | tuple[float, float] | str, step: float) -> list[float]:
    """Return angles other than 0 that a tool may be turned by about itself."""
    if allowed == "free":
        return np.arange(step, 2.0 * np.pi - 1e-9, step).tolist()
    most = max(_both(allowed))
    inner = np.arange(step, most - 1e-9, step).tolist()
    return [sign * one for one in (*inner, most) for sign in (1.0, -1.0)] if most > 0.0 else []


def _both(allowed: float | tuple[float, float] | str) -> tuple[float, ...]:
    return (0.0, allowed, -allowed) if isinstance(allowed, float) and allowed > 0.0 else (0.0,)


def _turned(x: float, y: float, z: float) -> Floats:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("XYZ", [x, y, z]).as_matrix()
    return pose


def _lengths(frames: Floats) -> Floats:
    return _lengths_of(frames[:, :3, 3])


def _lengths_of(points: Floats, *, share: bool = False) -> Floats:
    """Return how far points (n, 3) are along the lines between them, in m or as a share of all."""
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return at / max(float(at[-1]), 1e-12) if share else at


def _places(at: Floats, apart: float) -> list[int]:
    """Return rows of places along a way that are so far apart, with both ends."""
    count = max(2, int(np.ceil(at[-1] / apart)) + 1)
    return np.unique(np.searchsorted(at, np.linspace(0.0, at[-1], count) - 1e-12).clip(0, len(at) - 1)).tolist()
