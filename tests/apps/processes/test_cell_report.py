"""Reports of cells: what stands there is what the plan and the world say; as PDF where there is a browser."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from virtualrobot import Client
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.demos.processes import CELLS
from virtualrobot_apps.processes import cell_report
from virtualrobot_apps.processes.command import process
from virtualrobot_apps.processes.process import plan_file

from tests.kernels import KernelProcess
from tools.screenshot import find_chromium


def tables(page: str) -> dict[str, list[list[str]]]:
    """Return the rows of each table, by the word that its heading begins with."""
    found = {}
    for section in page.split("<h2>")[1:]:
        rows = re.findall(r"<tr>(.*?)</tr>", section)
        cells = [[html.unescape(one) for one in re.findall(r"<td[^>]*>(.*?)</td>", row)] for row in rows]
        found[re.split(r"\W", section)[0]] = [row for row in cells if row]
    return found


@pytest.mark.long
def test_a_report_tells_what_the_plan_and_the_world_say(steps: Client) -> None:
    """Its steps last as long as the motion; joints are where the plan has them; the needle is 2 mm over the lid."""
    steps.scene.load_scene(CELLS / "gluing.yaml")
    made = plan_file(steps, CELLS / "dispense.yaml")
    checked = made.program.check()
    found = tables(cell_report.cell_report(steps, "glue", made, checked))
    cycle = found["Cycle"]
    assert sum(float(row[2]) for row in cycle) == pytest.approx(checked.duration, abs=0.1)
    bead = next(row for row in cycle if row[1] == "call bead 1")
    assert float(bead[2]) == pytest.approx(8.79, abs=0.02)
    # The needle's way is a circle 2 mm beside the bead's, of 135.6 mm, along the normal of a ball of 250 mm.
    assert float(bead[3]) == pytest.approx(2.0 * np.pi * np.sqrt(0.25**2 - 0.21**2) * 1.008, rel=2e-3)
    plan = made.program.plan().robots["arm"]
    for row in found["Reach"]:
        column = plan.joint_names.index(row[0].removeprefix("arm "))
        np.testing.assert_allclose(
            [float(row[1]), float(row[2])], [f(plan.positions[:, column]) for f in (np.min, np.max)], atol=6e-4
        )
        limit = steps.robot("arm").limits[row[0].removeprefix("arm ")]
        assert float(row[4]) == pytest.approx(min(float(row[1]) - limit.lower, limit.upper - float(row[2])), abs=2e-3)
        assert 0.0 < float(row[5]) <= 100.0
    pair, other, near, _ = found["Clearances"][0]
    assert {pair, other} == {"dispenser", "lid"} and float(near) == pytest.approx(2.0, abs=0.15)
    assert ["arm", "robot"] in found["Devices"] and ["valve", "signal, False"] in found["Devices"]
    assert len(found["Process"]) == 0


@pytest.mark.long
@pytest.mark.skipif(find_chromium() is None, reason="no Chromium: install the package chromium to print PDF")
def test_a_report_is_printed_as_pdf(stepped_kernel: KernelProcess, steps: Client, tmp_path: Path) -> None:
    steps.scene.load_scene(CELLS / "gluing.yaml")
    for name, begins in (("cell.pdf", b"%PDF-"), ("cell.html", b"<!doctype html>")):
        line = ["plan", str(CELLS / "dispense.yaml"), "--report", str(tmp_path / name)]
        done = CliRunner().invoke(process, [*line, "--address", stepped_kernel.address])
        assert done.exit_code == 0, done.output
        assert (tmp_path / name).read_bytes().startswith(begins)


def test_what_can_not_be_written_is_told_before_anything_is_planned(tmp_path: Path) -> None:
    for name, words in (("a.doc", "a report is .html or .pdf, not a.doc"), ("none/a.html", "there is no folder")):
        done = CliRunner().invoke(process, ["plan", "work.yaml", "--report", str(tmp_path / name)])
        assert done.exit_code == 2 and words in done.output


def test_without_a_browser_pdf_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cell_report, "BROWSERS", ("no-such-browser",))
    with pytest.raises(WrongStateError, match=r"one of no-such-browser: install one, or write \.html"):
        cell_report.write_report("<p>", tmp_path / "a.pdf")
    cell_report.write_report("<p>", tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text() == "<p>"
