"""Denavit-Hartenberg tables and the component `dh`: against closed forms, against URDF robots, and what is refused."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.dh import DhKinematics
from virtualrobot_sdk.denavit_hartenberg import Row, Table, frames, plain, pose, serial_arrays, transform
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, InverseOptions, InverseStatus, SerialChain
from virtualrobot_sdk.selfcheck import SelfCheck, finite_differences, self_check
from virtualrobot_sdk.settings import make_settings, schema

from .chain.arms import arm_chain
from .chain.chains import random_chain

RIGHT = np.pi / 2
TURNS, SLIDES = "revolute", "prismatic"

# P. I. Corke and B. Armstrong-Helouvry, A search for consensus among model parameters reported for the PUMA 560 robot,
# ICRA 1994: standard. The pedestal is 26.45 inch high.
PUMA = Table(
    "standard",
    (
        Row(TURNS, 0.0, RIGHT, 0.0),
        Row(TURNS, 0.4318, 0.0, 0.0),
        Row(TURNS, 0.0203, -RIGHT, 0.15005),
        Row(TURNS, 0.0, RIGHT, 0.4318),
        Row(TURNS, 0.0, -RIGHT, 0.0),
        Row(TURNS, 0.0, 0.0, 0.0),
    ),
    base_t_first=(0.0, 0.0, 0.67183, 0.0, 0.0, 0.0, 1.0),
)


def random_row(rng: np.random.Generator, kind: str = TURNS) -> Row:
    a, d = rng.uniform(-0.5, 0.5, 2).tolist()
    alpha, theta = rng.uniform(-np.pi, np.pi, 2).tolist()
    return Row(kind, a, alpha, d, theta)  # pyright: ignore[reportArgumentType]


def random_table(rng: np.random.Generator, convention: str) -> Table:
    """Return a table with both kinds of joints and two end pieces whose quaternions have any length."""
    rows = tuple(random_row(rng, kind) for kind in (TURNS, SLIDES, TURNS, TURNS, SLIDES, TURNS, TURNS))
    ends = [tuple(rng.uniform(-1.0, 1.0, 7).tolist()) for _ in range(2)]
    return Table(convention, rows, *ends)  # pyright: ignore[reportArgumentType]


def chain_of(table: Table) -> SerialChain:
    """Return a chain with the table's geometry and wide limits."""
    pre, axis, joint_type, post, _ = serial_arrays(table)
    n = len(table.rows)
    far = np.full(n, 3.0)
    names = tuple(f"joint_{i + 1}" for i in range(n))
    index = np.arange(n, dtype=np.int32)
    return SerialChain(pre, axis, joint_type, index, np.ones(n), np.zeros(n), post, -far, far, names)


def check(chain: SerialChain, table: Table, rng: np.random.Generator) -> SelfCheck:
    """Return how far a table is from a chain, as the kernel finds it when it is asked to use it."""
    tree = ChainKinematics(chain)
    return self_check(DhKinematics(chain, table), chain, lambda q: tree.forward(q)[-1], rng)


def rotation(axis: str, angle: float) -> np.ndarray:
    turned = np.eye(4)
    turned[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
    return turned


def shift(x: float = 0.0, z: float = 0.0) -> np.ndarray:
    moved = np.eye(4)
    moved[:3, 3] = x, 0.0, z
    return moved


def test_a_row_is_the_product_of_four_steps(rng: np.random.Generator) -> None:
    """Paul 1981: Rz Tz Tx Rx; Craig 1986: Rx Tx Rz Tz; rotations by SciPy."""
    for kind in (TURNS, SLIDES):
        row, q = random_row(rng, kind), float(rng.uniform(-1.0, 1.0))
        theta, d = row.theta_radians + q * (kind == TURNS), row.d_meters + q * (kind == SLIDES)
        about_z = rotation("z", theta) @ shift(z=d)
        about_x = shift(x=row.a_meters) @ rotation("x", row.alpha_radians)
        np.testing.assert_allclose(transform(row, "standard", q), about_z @ about_x, atol=1e-15)
        np.testing.assert_allclose(transform(row, "modified", q), about_x @ about_z, atol=1e-15)


def test_the_printed_matrices(rng: np.random.Generator) -> None:
    """Standard: Siciliano et al. 2009, eq. 2.52. Modified: Craig 1986, eq. 3.6."""
    row = random_row(rng)
    a, d = row.a_meters, row.d_meters
    (st, sa), (ct, ca) = (np.array([f(row.theta_radians), f(row.alpha_radians)]) for f in (np.sin, np.cos))
    paul = [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
    craig = [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -sa * d], [st * sa, ct * sa, ca, ca * d], [0, 0, 0, 1]]
    np.testing.assert_allclose(transform(row, "standard"), paul, atol=1e-15)
    np.testing.assert_allclose(transform(row, "modified"), craig, atol=1e-15)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_the_component_is_the_product_of_the_rows(rng: np.random.Generator, convention: str) -> None:
    table = random_table(rng, convention)
    chain = chain_of(table)
    component = DhKinematics(chain, table)
    for q in rng.uniform(-2.0, 2.0, (5, 7)):
        np.testing.assert_allclose(component.forward(q), frames(table, q), atol=1e-13)
        expected = finite_differences(lambda at: frames(table, at)[-1], q)
        np.testing.assert_allclose(component.jacobian(q), expected, atol=1e-8)
        result = component.inverse(frames(table, q)[-1], InverseOptions(seed=q + 0.05))
        np.testing.assert_allclose(frames(table, result.solutions[0])[-1], frames(table, q)[-1], atol=1e-8)


def test_both_conventions_tell_the_same_arm(rng: np.random.Generator) -> None:
    """Law: a standard table is the modified one whose a and alpha stand one row later; the last ones end the arm."""
    table = random_table(rng, "standard")
    lengths = [(0.0, 0.0), *((row.a_meters, row.alpha_radians) for row in table.rows)]
    rows = tuple(
        Row(row.type, a, alpha, row.d_meters, row.theta_radians)
        for row, (a, alpha) in zip(table.rows, lengths[:-1], strict=True)
    )
    a, alpha = lengths[-1]
    end = shift(x=a) @ rotation("x", alpha) @ pose(table.last_t_flange)
    flange = (*end[:3, 3].tolist(), *Rotation.from_matrix(end[:3, :3]).as_quat().tolist())
    modified = Table("modified", rows, table.base_t_first, flange)
    q = rng.uniform(-2.0, 2.0, 7)
    np.testing.assert_allclose(frames(modified, q)[-1], frames(table, q)[-1], atol=1e-14)
    found = check(chain_of(table), modified, rng)
    assert found.failures() == ()


def test_the_published_table_fits_the_puma_s_urdf(rng: np.random.Generator) -> None:
    """Our URDF, read without our importer; the self-check says so, and a table that is 1.3 mm longer does not fit."""
    chain = arm_chain("puma560")
    assert check(chain, PUMA, rng).failures() == ()
    rows = list(PUMA.rows)
    rows[3] = Row(TURNS, 0.0, RIGHT, 0.4331)  # Armstrong, Khatib and Burdick 1986
    found = check(chain, Table("standard", tuple(rows), PUMA.base_t_first), rng)
    assert found.forward_position == pytest.approx(0.0013, rel=1e-6)
    assert found.forward_rotation < 1e-9
    assert "forward puts the tip 0.0013 m and" in found.failures()[0]


def test_coupled_joints_and_limits_stay_the_robot_s(rng: np.random.Generator) -> None:
    """A mimic joint moves by its own factor and offset; limits are those of the robot."""
    table = random_table(rng, "standard")
    kinds = [PRISMATIC if row.type == SLIDES else REVOLUTE for row in table.rows]
    chain = random_chain(rng, kinds, [0, 1, 2, 0, 3, 4, 2])
    component = DhKinematics(chain, table)
    q = 0.5 * chain.upper
    values = chain.multiplier * q[chain.q_index] + chain.offset
    np.testing.assert_allclose(component.forward(q), frames(table, values), atol=1e-13)
    within = component.inverse(component.forward(q)[-1], InverseOptions(seed=q + 0.01))
    np.testing.assert_allclose(within.solutions[0], q, atol=1e-8)
    # Five coordinates and six conditions: no other posture reaches the pose.
    outside = InverseOptions(seed=chain.upper, max_restarts=20)
    assert component.inverse(component.forward(chain.upper + 0.2)[-1], outside).status is not InverseStatus.SOLVED


def test_a_table_that_does_not_fit_the_robot_is_refused() -> None:
    chain = arm_chain("puma560")
    with pytest.raises(ArgumentError, match=r"the table has 5 rows, but the robot has 6 joints .*joint1, joint2"):
        DhKinematics(chain, Table("standard", PUMA.rows[:5]))
    rows = (*PUMA.rows[:2], Row(SLIDES), *PUMA.rows[3:])
    with pytest.raises(ArgumentError, match=r"rows\[2\] is prismatic, but the robot's joint 'joint3' is revolute"):
        DhKinematics(chain, Table("standard", rows))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rows": [{}]}, "setting 'convention' is missing"),
        ({"convention": "paul", "rows": [{}]}, "setting 'convention' is 'paul'; it must be one of"),
        ({"convention": "standard", "rows": []}, "rows is empty; a Denavit-Hartenberg table has a row for each joint"),
        ({"convention": "standard", "rows": [{}, {"a": 1.0}]}, "there is no setting 'rows[1].a'"),
        ({"convention": "standard", "rows": [{"alpha_radians": "90"}]}, "setting 'rows[0].alpha_radians' is '90'"),
        ({"convention": "standard", "rows": [{"d_meters": np.nan}]}, "setting 'rows[0].d_meters' is nan"),
        ({"convention": "standard", "rows": [{"d_meters": 1e300}]}, "setting 'rows[0]': d_meters is 1e+300"),
        ({"convention": "standard", "rows": [{"type": "floating"}]}, "setting 'rows[0].type' is 'floating'"),
        ({"convention": "standard", "rows": [{}], "base_t_first": [0.0] * 6}, "it must be a list of length 7"),
        ({"convention": "standard", "rows": [{}], "last_t_flange": [0.0] * 7}, "the quaternion not zero"),
    ],
)
def test_settings_that_are_wrong_are_refused_by_name(given: dict, message: str) -> None:
    with pytest.raises(ArgumentError) as refused:
        make_settings(Table, given)
    assert message in str(refused.value)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_plain_values_give_the_table_again(rng: np.random.Generator, convention: str) -> None:
    """Through JSON too; what is a default is left out."""
    table = random_table(rng, convention)
    assert make_settings(Table, plain(table)) == table
    assert make_settings(Table, msgspec.json.decode(msgspec.json.encode(plain(table)))) == table
    assert plain(Table("standard", (Row(), Row(SLIDES)))) == {"convention": "standard", "rows": [{}, {"type": SLIDES}]}
    assert schema(Table)["required"] == ["convention", "rows"]
    assert all("description" in field for field in schema(Table)["$defs"]["Row"]["properties"].values())
