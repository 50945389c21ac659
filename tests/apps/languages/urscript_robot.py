"""Scripts in URScript on an emulated controller with an arm of its own, for tests; a cycle is 2 ms."""

from __future__ import annotations

import textwrap

import numpy as np
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.kinematics import Floats
from virtualrobot_apps.emulators.ur.scripts import run_script

HOME = np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])


class Played:
    """A controller that has played a script, and where its setpoint has been in each cycle."""

    def __init__(self, statements: str, cycles: int = 5000, controller: Controller | None = None) -> None:
        """Play statements of a program to its end."""
        self.controller = controller or Controller(SimulatedArm(HOME))
        targets = []
        run_script(self.controller, f"def tried():\n{textwrap.dedent(statements)}\nend\n")
        while self.controller.program is not None and len(targets) < cycles:
            self.controller.cycle()
            targets.append(self.controller.target.copy())
        self.targets = np.array(targets)

    @property
    def said(self) -> list[str]:
        """Lines of its log, and what is wrong."""
        return [*self.controller.logged, *(text for _, _, text in self.controller.words)]

    @property
    def places(self) -> Floats:
        """Positions (n, 3) of the TCP in each cycle."""
        return np.array([self.pose(one)[:3, 3] for one in self.targets])

    def pose(self, positions: Floats) -> Floats:
        """Return the pose (4, 4) of the TCP."""
        return kinematics.forward(self.controller.model, positions, self.controller.tcp)
