"""Programs in RAPL-II whose arm is a real one: a computed controller on a cable, by the driver `crs`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import pytest
import virtualrobot
from virtualrobot.cli.options import Session, Target
from virtualrobot.cli.shell import run_line

from tests.drivers.cables import Cable
from tests.drivers.rapl import Controller

pytestmark = pytest.mark.long

CARRY = """
10 APPRO %0, 30
20 MOVE %0, S
30 FINISH
40 OUTPUT 1
50 TYPE 'taken'
60 DEPART 30, S
70 APPRO %1, 30
80 MOVE %1, S
90 FINISH
100 OUTPUT -1
110 TYPE 'put'
120 DEPART 30, S
"""
PALLET = """
10 SPEED 100
20 ! N = 0
30 SET TAKE = FIRST
40 SET PUT = DROP
50 GOSUB CARRY TAKE, PUT
60 SHIFT TAKE, 0, 40, 0
70 SHIFT PUT, -40, 0, 0
80 ++ N
90 IF N < 2 THEN 50
100 MA 0, 1.5708, -1.5708, 0, 0
110 FINISH
120 TYPE 'done'
"""
PLACES = "POINT FIRST 300, -80, 150, 0, 90, 0\nPOINT DROP 150, 250, 150, 0, 90, 0\n"


@pytest.fixture
def controller(tmp_path: Path) -> Iterator[tuple[Controller, Path]]:
    """Yield the controller of an A255, which stands upright, and the path of its cable."""
    cable, controller = Cable(tmp_path), Controller(joints=5)
    controller.at = controller.goal = np.array([0.0, 90.0, -90.0, 0.0, 0.0])
    cable.serve(controller)
    yield controller, cable.path
    cable.unplug()


def test_a_palletizing_program_moves_a_real_arm(
    client: virtualrobot.Client,
    controller: tuple[Controller, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """After each FINISH the arm itself is at its place, as its controller's joints and the model's kinematics tell."""
    real, port = controller
    arm = client.load_robot("model://a255", name="arm")
    for name, text in (("pallet.rpl", PALLET), ("carry.rpl", CARRY), ("pallet.loc", PLACES)):
        tmp_path.joinpath(name).write_text(text.lstrip())
    session, said = Session(client), list[tuple[str, np.ndarray]]()
    target = Target(session=session)

    def heard(message: object = "", **_: object) -> None:
        said.append((str(message), real.at.copy()))

    def typed(line: str) -> None:
        assert run_line(line, target) == 0, [words for words, _ in said]

    monkeypatch.setattr(click, "echo", heard)
    settings = f"--set port={port} --set baud=115200 --set silence_seconds=20 --lead 0.4"
    typed("collision mode guard")
    typed(f"driver connect arm crs {settings} --without-watchdog")
    try:
        typed("lease arm")
        typed("driver mode arm execute")
        said.clear()
        files = f"{tmp_path}/pallet.rpl {tmp_path}/carry.rpl --locations {tmp_path}/pallet.loc"
        typed(f"rapl run {files} --robot arm --create-signals")
    finally:
        session.release()
        client.drivers.disconnect("arm")
    assert [words for words, _ in said] == ["taken", "put", "taken", "put", "done"]
    places = [1000.0 * arm.solve_forward(list(np.radians(at))).world_t_tcp[:3, 3] for _, at in said]
    wanted = [(300, -80, 150), (150, 250, 150), (300, -40, 150), (110, 250, 150)]
    # Half a degree of each joint is that far at most, at the end of an arm of half a metre.
    np.testing.assert_allclose(places[:4], wanted, atol=10.0)
    np.testing.assert_allclose(said[-1][1], [0, 90, -90, 0, 0], atol=0.5)
    assert "HALT" not in real.typed[: real.typed.index("MA 0.00000,1.57080,-1.57080,0.00000,0.00000")]
