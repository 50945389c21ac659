"""Arms of our own: their axes agree with the makers' tables, with models of other packages and with the data sheets."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scipy.optimize import minimize
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.planning.robots import arm_of, world_poses
from virtualrobot_kernel.scenes.models import read_model
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import SerialChain

from tests.tiers import every_fifth
from tests.unit.formats.models import MODELS, XacroOnly, disk
from tests.unit.world.builders import after, empty

OURS = [name for name, model in MODELS.items() if model.scene and model.kind not in ("gripper", "legged")]

MEASURED_TO_THE_FLANGE = {"crx10ia", "tx2_60", "tx2_60l", "tx2_90", "rx160", "m0609", "m1013", "a465"}
"""Arms whose makers tell the reach of the flange; the others tell that of the wrist centre."""

NOT_STRETCHED = {"iiwa7", "xarm7", "gen3", "panda_arm"}
"""Arms whose makers tell the reach from the shoulder, or in a way of their own."""

# Universal Robots, DH parameters for calculations of kinematics and dynamics: d1, a2, a3, d4, d5, d6 (m).
UNIVERSAL_ROBOTS = {
    "ur3": (0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "ur5": (0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "ur10": (0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "ur3e": (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "ur16e": (0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
    "ur20": (0.2363, -0.8620, -0.7287, 0.2010, 0.1593, 0.1543),
    "ur30": (0.2363, -0.6370, -0.5037, 0.2010, 0.1593, 0.1543),
}

STRETCHED = [name for name in OURS if name not in {*UNIVERSAL_ROBOTS, *NOT_STRETCHED, "cobra600", "a255"}]


def chain_of(name: str) -> SerialChain:
    files = disk()
    request = scene_pb2.ModelSource(uri=f"model://{name}")
    world = after(empty(), CreateNodes(read_model(MeshLibrary(files.store, XacroOnly()), request, files, ()).nodes))
    robot = next(node for node in world.structure.nodes.values() if node.kind is Kind.ROBOT)
    poses = world_poses(world.structure, world.state)
    return arm_of(Snapshot(world.structure, world.state, poses, 0, 0.0, 0.004), robot).serial()


def row(theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    """Return Rz(theta) Tz(d) Tx(a) Rx(alpha), standard Denavit-Hartenberg (R. P. Paul, Robot Manipulators, 1981)."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


@pytest.mark.parametrize("name", UNIVERSAL_ROBOTS)
def test_arms_of_universal_robots_are_those_of_the_makers_table(name: str, rng: np.random.Generator) -> None:
    d1, a2, a3, d4, d5, d6 = UNIVERSAL_ROBOTS[name]
    right = np.pi / 2.0
    solver = ChainKinematics(chain_of(name))
    for q in rng.uniform(-np.pi, np.pi, (20, 6)):
        expected = row(q[0], d1, 0, right) @ row(q[1], 0, a2, 0) @ row(q[2], 0, a3, 0)
        expected = expected @ row(q[3], d4, 0, right) @ row(q[4], d5, 0, -right) @ row(q[5], d6, 0, 0)
        np.testing.assert_allclose(solver.forward(q)[-1], expected, atol=1e-9)


def test_the_scara_is_that_of_robotics_toolbox(rng: np.random.Generator) -> None:
    other = pytest.importorskip("roboticstoolbox", reason="a peer of `make bench`").models.DH.Cobra600()
    solver = ChainKinematics(chain_of("cobra600"))
    for q in rng.uniform((-0.8, -1.5, 0.0, -3.0), (0.8, 1.5, 0.2, 3.0), (20, 4)):
        np.testing.assert_allclose(solver.forward(q)[-1], other.fkine(q).A, atol=1e-9)


@pytest.mark.parametrize("name", every_fifth(STRETCHED))
def test_the_reach_is_that_of_the_data_sheet(name: str) -> None:
    """The greatest distance from axis 1, over all that joints 2, 3 and 5 do within limits; makers round it."""
    chain = chain_of(name)
    solver = ChainKinematics(chain)
    point = -1 if name in MEASURED_TO_THE_FLANGE else 4
    lower, upper = chain.lower[[1, 2, 4]], chain.upper[[1, 2, 4]]

    def shortness(moved: np.ndarray) -> float:
        q = np.zeros(6)
        q[[1, 2, 4]] = moved
        return -float(np.hypot(*solver.forward(q)[point][:2, 3]))

    starts = np.linspace(lower, upper, 7)
    tried = [np.array([a, b, c]) for a in starts[:, 0] for b in starts[:, 1] for c in starts[::3, 2]]
    best = sorted(tried, key=shortness)[:3]
    bounds = list(zip(lower, upper, strict=True))
    reach = -min(minimize(shortness, start, method="L-BFGS-B", bounds=bounds).fun for start in best)
    assert reach == pytest.approx(MODELS[name].reach_meters, abs=0.006)


def test_the_arm_of_five_joints_reaches_22_inches_when_it_is_stretched_out() -> None:
    """A255, as commonly told: a reach of 22 in from axis 1 to the flange, links of 10, 10, 2 in, the shoulder at 10."""
    flange = ChainKinematics(chain_of("a255")).forward(np.zeros(5))[-1]
    np.testing.assert_allclose(flange[:3, 3], [22 * 0.0254, 0.0, 10 * 0.0254], atol=1e-12)


def test_iiwa_7_is_the_iiwa_14_with_shorter_links(rng: np.random.Generator) -> None:
    """Flange of the iiwa 7 at zero: 340 + 400 + 400 + 126 mm; reach 800 mm from shoulder to wrist centre."""
    frames = ChainKinematics(chain_of("iiwa7")).forward(np.zeros(7))
    assert frames[-1][2, 3] == pytest.approx(0.34 + 0.4 + 0.4 + 0.126)
    assert frames[5][2, 3] - frames[1][2, 3] == pytest.approx(MODELS["iiwa7"].reach_meters)


@pytest.mark.parametrize("name", OURS)
def test_every_arm_tells_its_source_and_its_simple_bodies(name: str) -> None:
    model = MODELS[name]
    assert model.maker and model.source and "simple bodies" in model.description
    assert model.payload_kilograms > 0.0 and model.reach_meters > 0.0
    robot, *links = json.loads(model.scene)["nodes"]
    moving = [link["link"]["joint"] for link in links if "FIXED" not in link["link"]["joint"]["type"]]
    assert [joint["name"] for joint in moving] == [f"joint_{i + 1}" for i in range(model.axes)]
    for posture in robot["robot"]["postures"]:
        for joint in moving:
            at = posture["joint_positions"][joint["name"]]
            assert joint["limits"]["lower"] - 1e-9 <= at <= joint["limits"]["upper"] + 1e-9
    assert all(re.fullmatch(r"[a-z0-9_]+", pair["first"]) for pair in robot["robot"]["allowed_collisions"])
