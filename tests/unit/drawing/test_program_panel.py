"""Panel of the page that shows programs, on a real server of pages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import viser
from virtualrobot_kernel.drawing.program_panel import ProgramPanel
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.commands import CreateSignal, PickPart, StartMotion
from virtualrobot_kernel.world.state import Signal, Snapshot

from tests.unit.world.builders import TICK, after, arm, empty, ticked


@pytest.fixture
def server() -> viser.ViserServer:
    """Return a server of pages that nobody looks at."""
    return viser.ViserServer(host="127.0.0.1", port=0, verbose=False)


def test_the_present_step_is_marked_among_its_neighbours(server: viser.ViserServer) -> None:
    stages = (
        Stage(None, (), ((0.0, 0),), wait=Wait(0.1), paths=("0[0].0",)),
        Stage(None, (), ((0.0, 1),), wait=Wait(0.0, Condition("go")), paths=("0[0].1",)),
        Stage(None, (), ((0.0, 2),), orders=(PickPart("arm"),), paths=("1",), pauses=True),
    )
    start = StartMotion((("arm", "a"),), Program(stages, np.zeros(1), 3))
    change = after(empty(), arm(), CreateSignal(Signal("go", False)), start)
    panel = ProgramPanel(server)

    def shown() -> str:
        state = change.state
        panel.show(Snapshot(change.structure, state, world_poses(change.structure, state), 0, 0.0, TICK))
        return panel._text.content if panel._folder.visible else ""

    assert shown().splitlines() == [
        "**motion-1** arm: running  ",
        "▶ **`0[0].0` dwell 0.1 s**  ",
        "`0[0].1` wait until go is on  ",
        "● `1` pick",
    ]
    change = ticked(change, 30)
    assert "`0[0].0` dwell 0.1 s  \n▶ **`0[0].1` wait until go is on**" in shown()
    change = replace(change, state=replace(change.state, motions=()))
    assert shown() == ""
    server.stop()
