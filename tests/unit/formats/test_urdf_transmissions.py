"""Transmissions of URDF files; the formulas are those of ros2_control's transmission_interface."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.formats.urdf_joints import read_joints
from virtualrobot_kernel.formats.urdf_transmissions import read_transmissions
from virtualrobot_kernel.formats.xml import FileWarning, parse_xml
from virtualrobot_kernel.world.structure import Actuator

JOINTS = "".join(
    f'<joint name="{name}" type="revolute"><parent link="x"/><child link="y"/>'
    f'<limit lower="-1" upper="1" velocity="1" effort="1"/>{more}</joint>'
    for name, more in (("a", ""), ("b", ""), ("follower", '<mimic joint="a"/>'))
)


def read(transmissions: str) -> tuple[tuple[Actuator, ...], list[FileWarning]]:
    root = parse_xml(f'<robot name="r">{JOINTS}{transmissions}</robot>'.encode(), "r.urdf")
    warnings: list[FileWarning] = []
    joints = [joint.joint for joint in read_joints("r.urdf", root, [])]
    return read_transmissions("r.urdf", root, joints, warnings), warnings


def simple(name: str, joint: str, reduction: object, inner: str = "") -> str:
    return (
        f'<transmission name="t_{name}"><type>transmission_interface/SimpleTransmission</type><joint name="{joint}">'
        f'{inner}</joint><actuator name="{name}"><mechanicalReduction>{reduction}</mechanicalReduction></actuator>'
        "</transmission>"
    )


def double(kind: str, m: np.ndarray, n: np.ndarray, o: np.ndarray) -> str:
    """Return a transmission of two joints, written in the wrong order, with the roles that say the right one."""
    joints, motors = (
        "".join(
            f'<{tag} name="{name}"><role>{tag}{i + 1}</role><mechanicalReduction>{ratio!r}</mechanicalReduction>'
            f"{f'<offset>{o[i]!r}</offset>' if tag == 'joint' else ''}</{tag}>"
            for i, name, ratio in ((1, names[1], float(ratios[1])), (0, names[0], float(ratios[0])))
        )
        for tag, names, ratios in (("joint", "ab", n), ("actuator", ("one", "two"), m))
    )
    return f'<transmission name="t"><type>transmission_interface/{kind}</type>{joints}{motors}</transmission>'


@pytest.mark.parametrize("kind", ["DifferentialTransmission", "FourBarLinkageTransmission"])
def test_two_joints_coupled(kind: str, rng: np.random.Generator) -> None:
    m, n, o, j = (values.round(6) for values in rng.uniform(0.5, 50.0, (4, 2)))
    (one, two), warnings = read(double(kind, m, n, [float(x) for x in o]))  # pyright: ignore[reportArgumentType]
    assert not warnings and (one.name, two.name) == ("one", "two")
    found = [x.offset + sum(ratio * {"a": j[0], "b": j[1]}[joint] for joint, ratio in x.terms) for x in (one, two)]
    first, second = j - o
    expected = {
        "DifferentialTransmission": (m[0] * (n[0] * first + n[1] * second), m[1] * (n[0] * first - n[1] * second)),
        "FourBarLinkageTransmission": (m[0] * n[0] * first, m[1] * (first + n[1] * second)),
    }[kind]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_a_simple_one_and_its_offset() -> None:
    found, warnings = read(simple("one", "a", -50, "<offset>0.1</offset>"))
    assert found == (Actuator("one", (("a", -50.0),), 5.0),) and not warnings


def test_motors_that_are_their_joints_say_nothing() -> None:
    assert read(simple("one", "a", 1) + simple("two", "b", 1.0)) == ((), [])


@pytest.mark.parametrize(
    ("transmissions", "why"),
    [
        (simple("one", "a", "reduction"), "<mechanicalReduction> is 'reduction', which is no finite number"),
        (simple("one", "a", "nan"), "is 'nan', which is no finite number"),
        (simple("one", "a", 0), "a mechanicalReduction is 0"),
        (simple("one", "c", 2), "'c' is no joint that is moved by itself"),
        (simple("one", "follower", 2), "'follower' is no joint that is moved by itself"),
        (simple("one", "a", 2) + simple("one", "b", 2), "there is another actuator 'one'"),
        (simple("one", "a", 2).replace("Simple", "Magic"), "unknown type 'MagicTransmission'; known: Simple"),
        (simple("one", "a", 2).replace("Simple", "Differential"), "1 actuators and 1 joints, expected 2 each"),
    ],
)
def test_what_is_wrong_is_told_and_no_actuator_is_taken(transmissions: str, why: str) -> None:
    found, (warning,) = read(simple("good", "b", 3) + transmissions)
    assert found == ()
    assert warning.startswith("r.urdf:1: transmission 't_one'") and why in warning
    assert warning.endswith("the robot's transmissions are left out")
