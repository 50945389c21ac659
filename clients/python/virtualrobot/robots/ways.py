"""Ways of crafts: planned lines and arcs, which can be looked at, checked, and started."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of
from virtualrobot._wire.services import Services
from virtualrobot.motions.program import Program
from virtualrobot.robots.mover import Mover
from virtualrobot.v1 import robot_pb2

Floats = NDArray[np.float64]


class Way(Program):
    """Way of a craft, a program whose moves are its lines and arcs; it stands between them.

    `start` drives it, `check` tells what it would touch with the base moving, and `plan` where all is on it.

    Attributes:
        parts: (n, 3) how far each part goes forward and to the left along the axes of the base (m), and turns (rad).
        joint_names: the joints of its drives.
        length: of the whole way (m), turns on the spot left out.
        word: of a way to a goal by arcs: left (L), right (R), straight (S), with a minus where it goes back.
        turning_radius: of these arcs (m); 0 where it turns on the spot.
        begin: x, y (m) and heading (rad) of the base where it begins, in the frame of the robot.
    """

    def __init__(
        self,
        services: Services,
        mover: Mover,
        solved: robot_pb2.SolveDrivesResponse,
        along: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        """Take what the kernel has solved; `Driving.way` and `Driving.way_to` make one.

        `along` are other joints that go along with the way, evenly from one position to another, by name.
        """
        super().__init__(services)
        self.parts: Floats = array_of(solved.parts)
        self.joint_names = tuple(solved.joint_names)
        self.length = solved.length_meters
        self.word = solved.word
        self.turning_radius = solved.turning_radius_meters
        self.begin = (solved.x_meters, solved.y_meters, solved.heading_radians)
        rows = array_of(solved.positions)
        steps = np.abs(np.diff(rows, axis=0)).max(axis=1, initial=0.0)
        gone = np.concatenate([[0.0], np.cumsum(steps)])
        shares = gone / gone[-1] if len(gone) > 1 and gone[-1] > 0.0 else np.ones(len(rows))
        if not len(rows) and along:
            self.move(mover.ptp({name: end for name, (_, end) in along.items()}))
        before = None
        for row, share in zip(rows, shares.tolist(), strict=True):
            if before is None or np.abs(row - before).max() > 0.0:
                positions = dict(zip(solved.joint_names, row.tolist(), strict=True))
                positions |= {name: start + share * (end - start) for name, (start, end) in (along or {}).items()}
                self.move(mover.ptp(positions))
            before = row

    def __repr__(self) -> str:
        """Return a line for people."""
        word = f" {self.word}" if self.word else ""
        return f"<Way{word} of {len(self.parts)} part{'s' * (len(self.parts) != 1)}, {self.length:.3f} m>"
