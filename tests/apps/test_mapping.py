"""The mapping application in a real kernel: what it finds, shows and saves, and how it ends."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.mapping import map_cell

pytestmark = pytest.mark.long

pytest.importorskip("pyoctomap", reason="pip install pyoctomap")
COMMAND = [sys.executable, "-m", "virtualrobot", "map", "--headless", "--speed"]


@pytest.fixture(scope="module")
def client() -> Iterator[virtualrobot.Client]:
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.speed_factor = 20.0
        yield client


def test_an_ideal_laser_maps_surfaces_only(
    client: virtualrobot.Client, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Echoes of an ideal sensor are on surfaces to float32; points within 1 mm of a side count for both voxels."""
    saved = tmp_path / "map.npz"
    result = map_cell.main(client, resolution=0.05, save=saved, headless=True)
    assert result.false_rate == 0.0 and result.occupied > 500
    assert result.visible > 500 and result.missed_rate < 0.05
    told = capsys.readouterr().out
    assert len(re.findall(r"^scan \d of 8: ", told, re.MULTILINE)) == 8 and "100.00 %" in told
    with np.load(saved) as file:
        centers, odds = file["centers"], file["log_odds"]
    occupied = centers[odds > 0.0]
    assert len(occupied) == result.occupied and (odds < 0.0).sum() > 1000
    steps = centers / 0.05 - 0.5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    # The ball's top and the drum's are there, and the air between them is free.
    sizes = {name: np.linalg.norm(centers - place, axis=1).argmin() for name, place in PLACES.items()}
    assert {name: bool(odds[index] > 0.0) for name, index in sizes.items()} == {
        "ball": True,
        "drum": True,
        "crate": True,
        "air": False,
    }
    (shown,), _ = client.scene._read(["map"], ("figures",))
    assert len(shown.figures) == result.occupied and all(one.HasField("box") for one in shown.figures)


PLACES = {
    "ball": np.array([0.843, -0.013, 0.219]),
    "drum": np.array([0.653, -0.287, 0.306]),
    "crate": np.array([0.72, 0.27, 0.266]),
    "air": np.array([0.725, -0.075, 0.325]),
}


def test_ultrasound_finds_far_more_than_chance(client: virtualrobot.Client) -> None:
    """Of 6048 cells of 5 cm about one in seven holds a surface; of those that count as occupied, every second one."""
    result = map_cell.main(client, ultrasonic=True, headless=True)
    cells = np.prod((map_cell.HIGH - map_cell.LOW) / 0.05)
    assert result.occupied > 200
    assert result.true / result.occupied > 2.5 * result.visible / cells
    assert result.missed_rate < 0.6


def test_ctrl_c_ends_it_and_keeps_the_map(tmp_path: Path) -> None:
    saved = tmp_path / "map.bt"
    process = subprocess.Popen(
        [*COMMAND, "5", "--save", str(saved)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    with process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("scan 2"):
                break
        os.killpg(process.pid, signal.SIGINT)
        rest = process.stdout.read()
        assert process.wait(60) == 130, rest
    assert f"saved as {saved}" in rest and rest.rstrip().endswith("stopped")
    assert saved.read_bytes().startswith(b"# Octomap OcTree binary file")


def test_a_grid_is_no_octree() -> None:
    done = subprocess.run(
        [*COMMAND, "5", "--ultrasonic", "--save", "map.bt"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 2 and "--save takes a name that ends in .npz" in done.stderr
    done = subprocess.run(
        [*COMMAND, "5", "--save", "none/map.bt"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 2 and "there is no folder none" in done.stderr
