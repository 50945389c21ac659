"""Curves of CAD files as programs in RAPID, which run in the interpreter on an IRB 2400: the tool is on the formula."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import RapidTask, load
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.writers.command import program as command

from tests.apps.cad_files import curve_element, iges, numbers, vda
from tests.apps.languages.tracing import traced
from tests.kernels import KernelProcess

pytestmark = pytest.mark.long

COEFFICIENTS = np.array([[0.0, 0.0, 0.0], [150.0, -60.0, 0.0], [-80.0, 350.0, 60.0], [30.0, -40.0, -40.0]])
"""A cubic in mm, in the frame of the fixture: x(t) = 150 t - 80 t^2 + 30 t^3, and so on."""
FIXTURE = virtualrobot.pose(0.85, -0.1, 0.9, yaw=0.3)
TOLERANCE = 1e-4


def cubic(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and derivatives (n, 3) of the cubic, in m, in the fixture's frame."""
    powers = np.arange(4)
    points = t[:, None] ** powers @ COEFFICIENTS
    slopes = (powers[1:] * t[:, None] ** powers[:-1]) @ COEFFICIENTS[1:]
    return 1e-3 * points, 1e-3 * slopes


def in_fixture(places: np.ndarray) -> np.ndarray:
    """Return places (n, 3) of the world in the fixture's frame."""
    return (np.linalg.inv(FIXTURE) @ np.c_[places, np.ones(len(places))].T).T[:, :3]


def between(places: np.ndarray, begin: np.ndarray, end: np.ndarray) -> slice:
    """Return the part of a way (n, 3) from where it first is at one place to where it last is at another."""
    first = np.flatnonzero(np.linalg.norm(places - begin, axis=1) < 1e-5)[0]
    last = np.flatnonzero(np.linalg.norm(places - end, axis=1) < 1e-5)[-1]
    return slice(int(first), int(last) + 1)


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an IRB 2400 with a pen before a fixture, in a world whose time goes five times as fast."""
    client.clock.speed_factor = 5.0
    arm = client.load_robot("model://irb2400_16_155", name="arm")
    arm.set_positions([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])
    client.scene.add_tool("pen", arm.flange, tool_center_points={"tip": virtualrobot.pose(z=0.12)})
    client.scene.select_tool("arm", "pen", "tip")
    client.scene.add_object("fixture", pose=FIXTURE)
    return arm


def run(kernel: KernelProcess, *arguments: str) -> str:
    """Return what `virtualrobot program curves` says; raises its error."""
    done = CliRunner().invoke(command, ["curves", *arguments, "--address", kernel.address], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return done.output


def test_a_curve_of_vda_fs_runs_in_rapid_within_the_tolerance(
    client: virtualrobot.Client, arm: virtualrobot.Robot, kernel: KernelProcess, tmp_path: Path
) -> None:
    file = tmp_path / "hood.vda"
    file.write_text(vda(curve_element("SEAM", [COEFFICIENTS])))
    said = run(kernel, str(file), "--as", "rapid", "--reference", "fixture", "--tolerance", str(TOLERANCE))
    module = file.with_suffix(".mod")
    assert said.endswith(f"statements in {module}\n")
    text = module.read_text()
    assert "MoveC" in text and "\\WObj:=in_fixture" in text and "v100, " in text
    checked = CliRunner().invoke(rapid, ["check", str(module)])
    assert checked.output == "no fault in 1 routine\n"
    loaded = load([Source(text, "hood.mod")], client.signals)

    # The plan of what the interpreter gives the kernel: also how the tool is turned.
    notes: list[str] = []
    poses = recorded(client, "arm", loaded, say=notes.append).plan().robots["arm"].world_t_tcp
    assert not notes
    places = in_fixture(poses[:, :3, 3])
    fine, slopes = cubic(np.linspace(0.0, 1.0, 20_001))
    part = between(places, fine[0], fine[-1])
    nearest = np.array([np.linalg.norm(fine - place, axis=1).argmin() for place in places[part]])
    distances = np.linalg.norm(fine[nearest] - places[part], axis=1)
    assert distances.max() <= TOLERANCE
    np.testing.assert_allclose(poses[part, :3, 2], [[0.0, 0.0, -1.0]] * len(nearest), atol=1e-6)
    x = poses[part, :3, 0] @ FIXTURE[:3, :3]
    across = slopes[nearest] * [1.0, 1.0, 0.0]
    cosines = np.einsum("ij,ij->i", x, across / np.linalg.norm(across, axis=1)[:, None])
    assert np.degrees(np.arccos(np.clip(cosines.min(), -1.0, 1.0))) < 2.0  # it turns evenly between the points
    assert np.linalg.norm(places[: part.start] - fine[0] - [0.0, 0.0, 0.05], axis=1).min() < 1e-5

    # The robot itself, tick by tick.
    places = in_fixture(traced(client, RapidTask(loaded, World(client, "arm", notes.append)).run)[:, 1:])
    part = between(places, fine[0], fine[-1])
    distances = [np.linalg.norm(fine - place, axis=1).min() for place in places[part]]
    assert max(distances) <= TOLERANCE
    left_out = [np.linalg.norm(places[part] - point, axis=1).min() for point in fine[::200]]
    assert (
        max(left_out) < 0.1 * 0.02 + TOLERANCE
    )  # no part of the curve was left out: 0.1 m/s, samples of a tick or two
    np.testing.assert_allclose(places[-1], fine[-1] + [0.0, 0.0, 0.05], atol=1e-5)


def test_a_line_and_an_arc_of_iges_in_inches_are_one_way(
    client: virtualrobot.Client, arm: virtualrobot.Robot, kernel: KernelProcess, tmp_path: Path
) -> None:
    """From (0, 0) to (4, 0) inches, then half a circle about (4, 2), up to (4, 4); the tool does not turn."""
    file = tmp_path / "part.igs"
    file.write_text(iges((110, "0.,0.,0.,4.,0.,0."), (100, f"0.,4.,2.,{numbers([4.0, 0.0, 4.0, 4.0])}"), unit=1))
    run(kernel, str(file), "--as", "rapid", "--reference", "fixture", "--no-turn", "--speed", "0.2")
    text = file.with_suffix(".mod").read_text()
    assert text.count("MoveJ") == 1 and text.count("MoveC") == 2 and text.count("MoveL") == 3
    poses = recorded(client, "arm", load([Source(text, "part.mod")], client.signals)).plan().robots["arm"].world_t_tcp
    places = in_fixture(poses[:, :3, 3]) / 0.0254
    part = between(0.0254 * places, np.zeros(3), 0.0254 * np.array([4.0, 4.0, 0.0]))
    on_line = places[part, 0] <= 4.0
    off = np.where(
        on_line & (places[part, 1] < 2.0),
        np.abs(places[part, 1]),
        np.abs(np.linalg.norm(places[part, :2] - [4.0, 2.0], axis=1) - 2.0),
    )
    assert 0.0254 * off.max() <= 1e-4 and 0.0254 * np.abs(places[part, 2]).max() <= 1e-5
    np.testing.assert_allclose(poses[part, :3, 0], [FIXTURE[:3, 0]] * len(off), atol=1e-6)


def test_what_is_out_of_reach_is_told_by_its_point(
    client: virtualrobot.Client, arm: virtualrobot.Robot, kernel: KernelProcess, tmp_path: Path
) -> None:
    file = tmp_path / "far.vda"
    file.write_text(vda("NEAR = PSET / 2, 0,0,0, 0,50,0", "FAR = PSET / 3, 0,0,0, 0,90,0, 2000,90,0"))
    with pytest.raises(virtualrobot.VirtualRobotError, match=r"^FAR, point 3: step \d+: "):
        run(kernel, str(file), "--as", "rapid", "--reference", "fixture", "--curve", "FAR")
    assert not file.with_suffix(".mod").exists()
    run(kernel, str(file), "--as", "krl", "--reference", "fixture", "--curve", "NEAR")
    assert "LIN" in file.with_suffix(".src").read_text()
    with pytest.raises(virtualrobot.VirtualRobotError, match="fixtur"):
        run(kernel, str(file), "--as", "rapid", "--reference", "fixtur", "--curve", "NEAR")


def test_rounds_that_turn_a_joint_too_far_are_told_with_a_way_out(
    client: virtualrobot.Client, arm: virtualrobot.Robot, kernel: KernelProcess, tmp_path: Path
) -> None:
    """Three rounds of a circle of 2 inches."""
    file = tmp_path / "rounds.igs"
    halves = [(100, f"0.,0.,0.,{numbers(list(ends))}") for ends in ((2.0, 0.0, -2.0, 0.0), (-2.0, 0.0, 2.0, 0.0))]
    file.write_text(iges(*halves * 3, unit=1))
    with pytest.raises(virtualrobot.LimitError, match=r"joint 'joint_6' would be at .*; the tool turns .* --no-turn"):
        run(kernel, str(file), "--as", "rapid", "--reference", "fixture", "--speed", "0.2")
