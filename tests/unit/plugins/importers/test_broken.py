"""Files of every kind that are cut off, damaged or no such files at all are refused in words, and soon."""

import re
import warnings

import numpy as np
import pytest
from virtualrobot_plugins.importers.dxf.importer import DxfImporter
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.step import StepImporter
from virtualrobot_plugins.importers.threemf import ThreeMfImporter
from virtualrobot_plugins.importers.vrml.importer import VrmlImporter
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Importer

from tests.tiers import Draws
from tests.unit.formats.models import DATA
from tests.unit.plugins.importers.reading import FILES, broken

CASES: dict[str, tuple[Importer, bytes, int]] = {
    "torus.dxf": (DxfImporter(), (FILES / "torus.dxf").read_bytes(), 50),
    "POLI-ALL210_12.DXF": (DxfImporter(), (FILES / "POLI-ALL210_12.DXF").read_bytes(), 50),
    "bored_block.step": (StepImporter(), (FILES / "bored_block.step").read_bytes(), 15),
    "torus.wrl": (VrmlImporter(), (FILES / "torus.wrl").read_bytes(), 75),
    "cell.wrl": (VrmlImporter(), (FILES / "cell.wrl").read_bytes(), 75),
    "pinned_plate.3mf": (ThreeMfImporter(), (FILES / "pinned_plate.3mf").read_bytes(), 75),
    "torus.ply": (PlyImporter(), (FILES / "torus.ply").read_bytes(), 75),
    "torus.off": (OffImporter(), (FILES / "torus.off").read_bytes(), 75),
    "arm.sdf": (SdfImporter(), (DATA / "kuka_iiwa/kuka_with_gripper.sdf").read_bytes(), 75),
}
"""Importer, a good file, and how many damaged ones are made of it."""


def translate(importer: Importer, data: bytes, name: str) -> str:
    """Return the refusal, or nothing when the file is taken; any other error ends the test."""
    try:
        with warnings.catch_warnings():
            # Libraries warn of numbers out of range; in a process of their own nobody hears it.
            warnings.filterwarnings("ignore", category=RuntimeWarning, module=r"trimesh|ezdxf")
            importer.translate(data, name, {})
    except ArgumentError as error:
        return str(error)
    except FilesNeeded as needed:
        assert all(needed.names)
    return ""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * name.endswith(".step")) for name in CASES]
)
def test_damaged_files(name: str, rng: np.random.Generator, draws: Draws) -> None:
    importer, data, count = CASES[name]
    assert translate(importer, data, name) == ""
    refused = 0
    for _ in range(draws(count)):
        message = translate(importer, broken(data, rng), name)
        assert message == "" or re.match(rf"{re.escape(name)}[:/]", message), message
        refused += message != ""
    print(f"{name}: {refused} refused")


@pytest.mark.parametrize("name", CASES)
def test_what_is_no_such_file(name: str, rng: np.random.Generator) -> None:
    importer, data, _ = CASES[name]
    other = b"\x7fELF" + rng.bytes(5000)
    texts = [
        b"",
        b" \n",
        b"\0" * 3000,
        rng.bytes(3000),
        other,
        "häßlich".encode("latin-1") * 100,
        data[: len(data) // 2],
    ]
    for text in texts:
        assert translate(importer, text, name).startswith(name)
    assert translate(importer, data[: len(data) // 10] + rng.bytes(2000), name).startswith(name)
