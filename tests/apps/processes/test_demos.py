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
    """Of prisms with 96 and 72 sides: n / 2 sin(2 pi / n) r^2 h; of a cap: pi h^2 (3 r - h) / 3; of a bent sheet."""
    area = [n / 2.0 * np.sin(2.0 * np.pi / n) * r**2 for n, r in ((96, 0.12), (72, 0.05))]
    assert workpieces.lid().volume == pytest.approx(np.pi * 0.08**2 * (3.0 * 0.25 - 0.08) / 3.0, rel=3e-3)
    assert workpieces.hood().volume == pytest.approx(0.5 * 0.6 * 0.004)
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
def test_two_arms_weld_two_seams_at_once(steps: virtualrobot.Client) -> None:
    """While the arcs burn, both wires are on their circles, 6 degrees from a right angle to the axis: within 0.05 mm.

    A chord of 72 sides is 0.08 mm inside. At any time both have gone as far, at 20 mm/s, within 0.5%; what is welded
    lies within 15 degrees of flat, and they end in the same tick.
    """
    radius, places, lean = workpieces.GROOVE, workpieces.GROOVES, workpieces.MITRE
    normal, welded, burning = np.array([np.cos(lean), 0.0, -np.sin(lean)]), [], []

    def look() -> None:
        burning.append((steps.signals["left_arc"], steps.signals["right_arc"]))
        if all(burning[-1]):
            pipe = steps.scene.pose("pipe")
            tips = [np.linalg.inv(pipe) @ steps.robot(name).state.world_t_tcp for name in ("left", "right")]
            welded.append([*tips, pipe])

    told = run.main(steps, CELLS / "pair.yaml", CELLS / "girth.yaml", each=look)
    poses = np.array(welded)
    off = poses[:, :2, :3, 3] - [[place, 0.0, 0.0] for place in places]
    assert np.abs(off @ normal).max() < 1e-4
    from_axis = np.linalg.norm(off, axis=2)
    assert radius - 1.5e-4 < from_axis.min() and from_axis.max() < radius + 5e-5
    turned = np.unwrap(np.arctan2(off[..., 1], off[..., 2] / np.cos(lean)), axis=0)
    assert np.abs(turned[:, 0] - turned[:, 1]).max() < 1e-3
    assert np.abs(turned[-1] - turned[0]) == pytest.approx(2.0 * np.pi, abs=0.01)
    rates = radius * np.abs(np.diff(turned, axis=0)) / 0.04
    np.testing.assert_allclose(np.median(rates, axis=0), 0.02, rtol=5e-3)
    # The torch is where the seam is wanted to look: its z is down in the world.
    down = np.einsum("nij,nkj->nki", poses[:, 2, :3, :3], poses[:, :2, :3, 2])
    assert np.degrees(np.arccos(np.clip(-down[..., 2], -1.0, 1.0))).max() < 15.0
    assert len({bool(one) == bool(other) for one, other in burning}) == 1
    seconds = [number((line,), r"in ([\d.]+) s,") for line in told[:2]]
    assert seconds[0] == seconds[1] and told[1].startswith("right, seam 1: 552.")


@pytest.mark.long
def test_two_arms_weld_twelve_spots_two_at_a_time(steps: virtualrobot.Client) -> None:
    """While both weld, each tip is where a spot is, within 0.1 mm: in six times all twelve."""
    welded: list[list[np.ndarray]] = []

    def look() -> None:
        hood = steps.scene.pose("hood")
        on = [steps.signals["left_weld"], steps.signals["right_weld"]]
        assert on[0] == on[1]
        if all(on):
            tips = [np.linalg.inv(hood) @ steps.robot(name).state.world_t_tcp for name in ("left", "right")]
            welded.append([tip[:3, 3] for tip in tips])

    told = run.main(steps, CELLS / "two_guns.yaml", CELLS / "tandem.yaml", each=look)
    wanted = np.array([steps.scene.target(f"spot_{k}").pose[:3, 3] for k in range(1, 13)])
    wanted = wanted - steps.scene.pose("hood")[:3, 3]
    apart = np.linalg.norm(np.array(welded)[:, :, None] - wanted, axis=3)
    assert apart.min(axis=2).max() < 1e-4
    assert set(apart.argmin(axis=2).ravel().tolist()) == set(range(12))
    assert number(told, r"(\d+) spots, welded") == 12


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


def watched(steps: virtualrobot.Client, name: str, signal: str, part: str) -> tuple[tuple[str, ...], np.ndarray]:
    """Return what a demo tells, and the tip's poses (n, 4, 4) in the part's frame each 40 ms while its signal is on."""
    poses = []

    def look() -> None:
        if steps.signals[signal]:
            poses.append(np.linalg.inv(steps.scene.pose(part)) @ steps.robot("arm").state.world_t_tcp)

    told = run.main(steps, CELLS / f"{DEMOS[name][0]}.yaml", CELLS / f"{name}.yaml", each=look)
    return told, np.array(poses)


def number(told: tuple[str, ...], pattern: str) -> float:
    """Return the number that one of the lines tells."""
    found = [match for line in told if (match := re.search(pattern, line))]
    assert len(found) == 1, told
    return float(found[0][1])


@pytest.mark.long
def test_a_hood_is_painted_as_rays_from_where_the_gun_was_say(
    steps: virtualrobot.Client, rng: np.random.Generator
) -> None:
    """250,000 rays of paint, drawn by chance, from where the gun was each 40 ms while it was open.

    In the middle a gun 0.2 m over a radius of 1.2 m at 0.3 m/s leaves flow / (speed step-over), by 1.4 / 1.2 more since
    the speed is the nozzle's.
    """
    told, poses = watched(steps, "paint", "trigger", "hood")
    hood, count = trimesh.load_mesh(CELLS / "hood.stl"), 500
    share = np.sqrt(1.0 - np.sqrt(rng.uniform(size=(len(poses), count))))
    about = rng.uniform(0.0, 2.0 * np.pi, size=share.shape)
    rays = np.stack([0.5 * share * np.cos(about), 0.5 * share * np.sin(about), np.ones_like(share)], axis=2)
    rays = np.einsum("nij,nmj->nmi", poses[:, :3, :3], rays).reshape(-1, 3)
    origins = np.repeat(poses[:, :3, 3], count, axis=0)
    faces = hood.ray.intersects_first(origins, rays / np.linalg.norm(rays, axis=1)[:, None])
    beside = 100.0 * np.mean(faces < 0)
    assert number(told, r"([\d.]+)% beside the part") == pytest.approx(beside, abs=0.7)
    assert len(poses) * 0.04 == pytest.approx(number(told, r"sprays for ([\d.]+) s"), rel=0.01)
    # Film in the middle of the hood, by the paint that falls there.
    middle = (np.abs(hood.triangles_center[:, 0]) < 0.15) & (np.abs(hood.triangles_center[:, 1]) < 0.15)
    middle &= hood.face_normals[:, 2] > 0.0
    volume = 2e-6 * 0.04 * len(poses) * np.isin(faces, np.flatnonzero(middle)).mean()
    film = 1e6 * volume / hood.area_faces[middle].sum()
    assert film == pytest.approx(1e6 * 2e-6 / (0.3 * 0.1) * 1.4 / 1.2, rel=0.02)
    assert number(told, r"([\d.]+) um in the mean") < number(told, r"([\d.]+) um at the most") < 1.12 * film


@pytest.mark.long
def test_a_bead_is_laid_once_around_a_lid(steps: virtualrobot.Client) -> None:
    """A section 40 mm below the top of a ball of 250 mm is a circle of 135.6 mm; the needle is 2 mm over it."""
    told, poses = watched(steps, "dispense", "valve", "lid")
    radius = np.sqrt(0.25**2 - 0.21**2)
    area = 0.5 * np.pi * 0.002**2
    assert number(told, r"([\d.]+) ml in beads") == pytest.approx(1e6 * area * 2.0 * np.pi * radius, rel=2e-3)
    centre = np.array([0.0, 0.0, -0.17])
    np.testing.assert_allclose(np.linalg.norm(poses[:, :3, 3] - centre, axis=1), 0.252, atol=2e-4)
    around = np.unwrap(np.arctan2(poses[:, 1, 3], poses[:, 0, 3]))
    assert abs(around[-1] - around[0]) == pytest.approx(2.0 * np.pi, abs=0.05)


@pytest.mark.long
def test_a_pad_is_pressed_on_a_lid_evenly(steps: virtualrobot.Client) -> None:
    """A spring of 10,000 N/m that is 3 mm in: 30 N. What the tip is below the ball is what the spring is in: 10%."""
    told, poses = watched(steps, "polish", "motor", "lid")
    assert number(told, r"pressed on by ([\d.]+) N") == 30.0
    depth = 0.25 - np.linalg.norm(poses[:, :3, 3] - [0.0, 0.0, -0.17], axis=1)
    np.testing.assert_allclose(1e4 * depth, 30.0, rtol=0.1)
    # The pad lies flat: its axis goes to the ball's middle, within what triangles of 2.4 degrees leave open.
    inward = -(poses[:, :3, 3] - [0.0, 0.0, -0.17]) / (0.25 - depth)[:, None]
    assert np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", inward, poses[:, :3, 2]), -1.0, 1.0))).max() < 3.0


@pytest.mark.long
def test_an_opening_is_cut_along_an_ellipse(steps: virtualrobot.Client) -> None:
    """The level 20 mm below the top of x^2 / 1.8 + y^2 / 2.4: half axes of 189.7 and 219.1 mm; half a kerf inside.

    Triangles are up to 0.06 mm inside the hood, which is 0.3 mm along its slope there; the chord is 0.5 mm.
    """
    told, poses = watched(steps, "cut", "beam", "hood")
    axes = np.sqrt([0.02 * 1.8, 0.02 * 2.4])
    at = np.linspace(0.0, 2.0 * np.pi, 20_001)
    ellipse = np.stack([axes[0] * np.cos(at), axes[1] * np.sin(at)], axis=1)
    length = np.linalg.norm(np.diff(ellipse, axis=0), axis=1).sum() - np.pi * 0.0004
    assert 1e-3 * number(told, r"cut 1: ([\d.]+) mm") == pytest.approx(length, rel=1e-3)
    assert number(told, r"([\d.]+) cm\^3 are cut away") == pytest.approx(1e6 * 0.0004 * 0.004 * length, rel=1e-3)
    nozzle = poses[:, :3, 3] + 0.002 * poses[:, :3, 2]
    np.testing.assert_allclose(nozzle[:, 2], -0.02, atol=5e-4)
    off = np.linalg.norm(nozzle[:, None, :2] - 0.9990 * ellipse[None, ::20], axis=2).min(axis=1)
    assert off.max() < 8e-4


@pytest.mark.long
def test_spots_are_welded_where_they_are_in_a_short_order(steps: virtualrobot.Client) -> None:
    """Twelve spots on x^2 / 1.8 + y^2 / 2.4; the shortest of all orders from the first one by dynamic programming."""
    told, poses = watched(steps, "spot", "weld", "hood")
    tips = poses[:, :3, 3]
    places = tips[np.concatenate([[True], np.linalg.norm(np.diff(tips, axis=0), axis=1) > 1e-3])]
    wanted = np.array([steps.scene.target(f"spot_{k}").pose[:3, 3] for k in range(1, 13)])
    wanted = wanted - steps.scene.pose("hood")[:3, 3]
    apart = np.linalg.norm(places[:, None] - wanted, axis=2)
    assert len(places) == 12 and sorted(apart.argmin(axis=1)) == list(range(12)) and apart.min(axis=1).max() < 1e-4
    np.testing.assert_allclose(-(places[:, 0] ** 2) / 1.8 - places[:, 1] ** 2 / 2.4, places[:, 2], atol=1e-4)
    gone = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert gone <= 1.02 * _shortest(wanted)
    assert number(told, r"(\d+) spots, welded") == 12


def _shortest(points: np.ndarray) -> float:
    """Return the length of the shortest way from the first of points through all others (Held and Karp, 1962)."""
    apart, count = np.linalg.norm(points[:, None] - points, axis=2), len(points)
    best = np.full((1 << count, count), np.inf)
    best[1, 0] = 0.0
    for visited in range(1, 1 << count, 2):
        for last in np.flatnonzero(np.isfinite(best[visited])).tolist():
            for to in range(1, count):
                if not visited >> to & 1:
                    after = visited | 1 << to
                    best[after, to] = min(best[after, to], best[visited, last] + apart[last, to])
    return float(best[-1].min())


@pytest.mark.long
def test_a_machine_is_tended_behind_its_hood(steps: virtualrobot.Client) -> None:
    """While its spindle turns the hood is closed and the arm is where it began; blanks are in the rack, to 0.01 mm."""
    seen = []

    def look() -> None:
        if steps.signals["spindle"]:
            machine = steps.robot("machine")
            places = dict(zip(machine.joint_names, machine.positions.tolist(), strict=True))
            seen.append([places["door"], places["axis"], *steps.robot("arm").positions])

    told = run.main(steps, CELLS / "shop.yaml", CELLS / "tend.yaml", each=look)
    assert told == ("2 parts through 'machine', 3 moves each in it",)
    doors, axes, *arm = np.array(seen).T
    np.testing.assert_allclose(doors, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.ptp(arm, axis=1), 0.0, atol=1e-9)
    assert axes.min() == pytest.approx(-0.1, abs=1e-3) and axes.max() == pytest.approx(0.1, abs=1e-3)
    placed = [steps.scene.pose(f"blank {number}")[:3, 3] for number in (1, 2)]
    np.testing.assert_allclose(placed, [[1.15, -0.75, 0.502], [1.15, -0.45, 0.502]], atol=1e-5)


@pytest.mark.long
def test_blanks_are_stacked_on_a_pallet(steps: virtualrobot.Client) -> None:
    """Two of each layer, the second one 60.5 mm higher, to 0.01 mm; each was let go a millimeter above its place."""
    told = run.main(steps, CELLS / "store.yaml", CELLS / "stack.yaml")
    assert told == ("4 parts in 2 layers of 2 x 1, 0 places left free",)
    placed = [steps.scene.pose(f"blank {number}")[:3, 3] for number in (1, 2, 3, 4)]
    wanted = [[x, 0.5, 0.601 + z + 0.001] for z in (0.0, 0.0605) for x in (0.9, 1.2)]
    np.testing.assert_allclose(placed, wanted, atol=1e-5)


def test_each_demo_has_its_files() -> None:
    for name, (cell, _) in DEMOS.items():
        assert (CELLS / f"{cell}.yaml").is_file() and (CELLS / f"{name}.yaml").is_file()
        assert name in demo.commands
