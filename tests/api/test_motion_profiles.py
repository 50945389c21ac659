"""The page of the kinds of motion: it tells of each that the contract has, with pictures that the kernel draws."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from virtualrobot.v1 import motion_pb2
from virtualrobot_apps import chart

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = (ROOT / "docs" / "motion-profiles.md").read_text("utf-8")
sys.path.insert(0, str(ROOT / "tools"))  # tools are no package
plot_motions = import_module("plot_motions")


def test_the_page_tells_of_each_move_of_the_contract() -> None:
    moves = [field.name for field in motion_pb2.Move.DESCRIPTOR.oneofs_by_name["move"].fields]
    told = re.findall(r"^## .*: `(\w+)`$", PAGE, re.MULTILINE)
    assert sorted(told) == sorted(moves)
    assert set(moves) <= set(plot_motions.PROFILES)


@pytest.mark.long
def test_each_picture_is_on_the_page_and_drawn_by_the_kernel(tmp_path: Path) -> None:
    shown = re.findall(r"\(pictures/motion-(\w+)\.svg\)", PAGE)
    assert sorted(shown) == sorted(plot_motions.PROFILES)
    done = CliRunner().invoke(plot_motions.main, [str(tmp_path)], catch_exceptions=False)
    assert done.exit_code == 0
    for name in shown:
        new, kept = (folder / f"motion-{name}.svg" for folder in (tmp_path, ROOT / "docs" / "pictures"))
        for file in (new, kept):
            curves = [line for line in ElementTree.parse(file).iter() if line.tag.endswith("polyline")]
            assert curves, file
            assert file.stat().st_size < 40_000
        assert _legend(new) == _legend(kept), "make profiles draws it anew"


def _legend(file: Path) -> list[str]:
    """Return the words of a picture, without numbers."""
    words = (text.text or "" for text in ElementTree.parse(file).iter() if text.tag.endswith("text"))
    return [word for word in words if not re.fullmatch(r"-?[\d.e-]+", word)]


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-0.013, 0.0), (-37.0, 122.0), (0.0, 0.0)])
def test_ticks_are_round_and_enclose_the_values(low: float, high: float) -> None:
    found = chart.ticks(low, high, 5)
    assert found[0] <= low and found[-1] >= high
    assert 2 <= len(found) <= 8
    step = found[1] - found[0]
    assert round(step / 10.0 ** np.floor(np.log10(step) + 1e-9), 6) in (1.0, 2.0, 5.0)
    np.testing.assert_allclose(np.diff(found), step)
