"""Demos of processes, in a kernel: where the tool goes while the signal is on, and what is taken off, by formulas."""

from __future__ import annotations

import re

import numpy as np
import pytest
import trimesh
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.demos.palletizing.command import demo
from virtualrobot_apps.demos.processes import CELLS, run, workpieces
from virtualrobot_apps.demos.processes.command import DEMOS

from tests.kernels import KernelProcess

_BRANCH, _PIPE = 0.05, 0.09
"""Radii (m) of the pipes that are welded."""


@pytest.mark.parametrize("body", workpieces.BODIES, ids=lambda one: one.__name__)
def test_the_file_of_a_body_is_what_its_function_makes(body) -> None:  # noqa: ANN001 one of BODIES
    made, kept = body(), trimesh.load_mesh(CELLS / f"{body.__name__}.stl")
    assert made.is_watertight and len(kept.faces) == len(made.faces)
    assert kept.volume == pytest.approx(made.volume, rel=1e-5)
    np.testing.assert_allclose(kept.bounds, made.bounds, atol=1e-6)


def test_the_bodies_have_the_volumes_of_their_formulas() -> None:
    """Of prisms with 96 and 72 sides: n / 2 sin(2 pi / n) r^2 h."""
    area = [n / 2.0 * np.sin(2.0 * np.pi / n) * r**2 for n, r in ((96, 0.12), (72, 0.05))]
    assert workpieces.flange().volume == pytest.approx(area[0] * 0.03 + area[1] * 0.03, rel=1e-6)


@pytest.mark.long
def test_a_branch_is_welded_along_the_saddle(steps: virtualrobot.Client) -> None:
    """While the arc burns the wire is on both pipes: within 1 mm, chords of 72 sides are 0.09 mm inside."""
    welded = []

    def look() -> None:
        if steps.signals["arc"]:
            state = steps.robot("arm").state
            welded.append((np.linalg.inv(steps.scene.pose("pipes")) @ state.world_t_tcp)[:3, 3])

    measures = run.main(steps, CELLS / "pipes.yaml", CELLS / "weld.yaml", each=look)
    assert measures[0].startswith("seam 1: 321.")
    x, y, z = np.array(welded).T
    assert len(welded) > 300
    np.testing.assert_allclose(np.hypot(x, y), _BRANCH, atol=1e-3)
    np.testing.assert_allclose(np.hypot(x, z), _PIPE, atol=1e-3)
    around = np.unwrap(np.arctan2(y, x))
    assert abs(around[-1] - around[0]) == pytest.approx(2.0 * np.pi, abs=0.05)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "volume"),
    [
        ("mill", np.pi * (75.0**2 - 65.0**2) * 4.0),
        ("drill", 8.0 * np.pi * 5.0**2 * 20.0),
    ],
)
def test_what_is_cut_off_is_that_of_the_formula(
    stepped_kernel: KernelProcess, stepped: object, name: str, volume: float
) -> None:
    """A groove between radii of 65 and 75 mm, 4 mm deep; eight holes of 10 mm, 20 mm deep; in cm^3 to 0.1%."""
    told = CliRunner().invoke(demo, [name, "--address", stepped_kernel.address, "--headless"])
    assert told.exit_code == 0, told.output
    found = re.search(r"([\d.]+) cm\^3 are taken off blank", told.output)
    assert found is not None and float(found[1]) == pytest.approx(1e-3 * volume, rel=2e-3)
    assert "it touches nothing" in told.output and re.search(r"done in \d+\.\d s", told.output)


def test_each_demo_has_its_files() -> None:
    for name, (cell, _) in DEMOS.items():
        assert (CELLS / f"{cell}.yaml").is_file() and (CELLS / f"{name}.yaml").is_file()
        assert name in demo.commands
