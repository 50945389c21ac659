"""The suite for importers: a small one and the bundled ones keep it; each wrong one is found by the law it breaks."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.importers import LAWS, ImporterContract, ImporterFacts
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.native_formats import check_native
from virtualrobot_sdk.testing.subject import Subject
from virtualrobot_sdk.testing.trial import Trial, examine

from tests.contract.breaking import broken
from tests.pybullet_models import pybullet_data

COMPONENTS = "tests.contract.components.importers"
BUNDLED = "virtualrobot_plugins.importers"
FILES = Path(__file__).resolve().parent.parent / "unit" / "plugins" / "importers" / "files"

TWO = b"include more.tri\n" + b"".join(b"%d 0 0\n0 1 0\n0 0 1\n" % i for i in range(1, 13))
FACTS = ImporterFacts({"two.tri": TWO}, {"more.tri": b"0 0 0\n1 0 0\n0 1 0\n"})
XACRO = (
    b'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="length" value="0.5"/>'
    b'<xacro:include filename="parts.xacro"/><xacro:macro name="arm" params="name"><link name="${name}"/>'
    b'<joint name="${name}_joint" type="revolute"><parent link="base"/><child link="${name}"/>'
    b'<origin xyz="${length} 0 0"/><limit lower="-1" upper="${2 * length}" effort="1" velocity="1"/></joint>'
    b'</xacro:macro><xacro:arm name="left"/><xacro:arm name="right"/></robot>'
)
PARTS = b'<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base"/></robot>'

WRONG = {
    "ShortHeader": ("formats", r"a \.glb that cannot be opened: its header says \d+ bytes; it has \d+"),
    "NumberErrors": ("damage", r"translate raised ValueError: .* \(importers\.py:\d+ in corner\)"),
    "InSetOrder": ("determinism", r"another translation the next time in another process"),
    "AsksAgain": ("missing", r"for two\.tri it asks for 'more\.tri' again"),
    "LooksItself": ("seclusion", r"this one: (reads \S*|scratch: )more\.tri"),  # in the temporary folder it says so
    "Downloads": ("seclusion", r"this one: socket\.connect \('127\.0\.0\.1', 9\)"),
    "TakesAnything": ("nonsense", r"an empty file called two\.tri was translated"),
}


def samples(*names: str) -> dict[str, bytes]:
    return {name: (FILES / name).read_bytes() for name in names}


class TestTri(ImporterContract):
    component = f"{COMPONENTS}:Tri"
    facts = FACTS


@pytest.mark.long
class TestDxf(ImporterContract):
    component = f"{BUNDLED}/dxf"
    facts = ImporterFacts(samples("POLI-ALL210_12.DXF"), damaged=10)


@pytest.mark.long
class TestOff(ImporterContract):
    component = f"{BUNDLED}/off"
    facts = ImporterFacts(samples("torus.off"))


class TestPly(ImporterContract):
    component = f"{BUNDLED}/ply"
    facts = ImporterFacts(samples("torus.ply"))


class TestSdf(ImporterContract):
    component = f"{BUNDLED}/sdf"
    name = "gripper/wsg50_one_motor_gripper_new.sdf"
    facts = ImporterFacts({"gripper.sdf": (Path(pybullet_data.getDataPath()) / name).read_bytes()})


@pytest.mark.long
class TestStep(ImporterContract):
    component = f"{BUNDLED}/step"
    facts = ImporterFacts(samples("bored_block.step"), damaged=3, uses_processes=True)


class TestThreeMf(ImporterContract):
    component = f"{BUNDLED}/threemf"
    facts = ImporterFacts(samples("pinned_plate.3mf"))


class TestVrml(ImporterContract):
    component = f"{BUNDLED}/vrml"
    facts = ImporterFacts(samples("cell.wrl", "torus.wrl"), damaged=30)


class TestXacro(ImporterContract):
    component = f"{BUNDLED}/xacro"
    facts = ImporterFacts({"r.xacro": XACRO}, {"parts.xacro": PARTS})


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(ImporterContract, f"{COMPONENTS}:{name}", law, seed, FACTS)
    assert re.search(said, found), found


@pytest.mark.parametrize(
    ("line", "said"),
    [("sphere: {radius: 0.1}", "radius"), ("sphere: {radius_meters: -1.0}", "radius_meters")],
    ids=["a field that there isn't", "a value that makes no sense"],
)
def test_a_scene_that_the_kernel_refuses_is_found(line: str, said: str) -> None:
    scene = f"schema_version: 1\nnodes:\n- name: ball\n  object: {{}}\n  figures:\n  - {line}\n"
    right = Translation(".yaml", scene.replace(line, "sphere: {radius_meters: 0.1}").encode())
    assert check_native(right, "this one") is right
    with pytest.raises(LawBroken, match=rf"this one gave a \.yaml .*: the kernel refuses it: .*{said}"):
        check_native(Translation(".yaml", scene.encode()), "this one")


def test_one_that_hangs_is_found(seed: int) -> None:
    subject = Subject("it", f"{COMPONENTS}:HangsOnDamage", "", {}, deadline_seconds=0.5)
    facts = dataclasses.replace(FACTS, damaged=20)
    with Trial(ComponentKind.IMPORTER, subject, facts) as trial:
        with pytest.raises(LawBroken, match=r"translate gave no answer within 0\.5 s"):
            examine(LAWS["damage"], trial, seed)
