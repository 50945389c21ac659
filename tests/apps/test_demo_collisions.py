"""The demo's robots are stopped when they touch what they may not, and in no tick of its work they do."""

from __future__ import annotations

import io
import threading
from contextlib import redirect_stdout, suppress

import pytest
import virtualrobot
from virtualrobot.collisions.watch import CollisionReport
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.palletizing import cell, palletize

TICKS = 25
"""Of a step; each of them is checked."""


@pytest.mark.long
def test_the_cell_is_watched_and_nothing_touches(monkeypatch) -> None:  # noqa: ANN001 pytest's
    """Two layers of two boxes, in STEPPED mode: the monitor looks at each tick."""
    monkeypatch.setattr(palletize, "ROWS", 1)
    reports: list[CollisionReport] = []
    over = threading.Event()

    def watch(watcher: virtualrobot.Client) -> None:
        with suppress(virtualrobot.VirtualRobotError):  # it is closed at the end
            reports.extend(watcher.collisions.watch())

    def step(stepper: virtualrobot.Client) -> None:
        while not over.is_set():
            stepper.clock.step(TICKS)

    with (
        KernelProcess(headless=True) as kernel,
        virtualrobot.connect(kernel.address) as stepper,
        virtualrobot.connect(kernel.address) as client,
    ):
        cell.load(client)
        assert client.collisions.settings.mode == "stop"
        assert not client.collisions.check().pairs
        client.clock.set_stepped()
        with virtualrobot.connect(kernel.address) as watcher:
            threads = [
                threading.Thread(target=watch, args=(watcher,)),
                threading.Thread(target=step, args=(stepper,)),
            ]
            for thread in threads:
                thread.start()
            try:
                with redirect_stdout(io.StringIO()) as text:
                    palletize.main(client, headless=True, layers=2)
            finally:
                over.set()
                threads[1].join()
            checks = next(client.collisions.watch()).checks
        threads[0].join()
    assert "total      8 in" in text.getvalue()
    assert checks > 1000
    assert [str(event) for report in reports for event in report.events] == []
    assert [report.touching for report in reports if report.touching] == []


@pytest.mark.long
def test_an_arm_that_runs_into_the_conveyor_stops() -> None:
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        cell.load(client)
        arm = client.robot("iiwa")
        client.clock.set_stepped()
        motion = arm.move_joints({"lbr_iiwa_joint_2": 1.5}, speed_factor=0.2, wait=False)
        client.clock.step(3000)
        with pytest.raises(virtualrobot.MotionAbortedError, match="touches"):
            motion.wait()
