"""The test kit finds what is wrong about each of the wrong plugins, names it, and survives it."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.chains import puma560
from virtualrobot_sdk.testing.examination import LAWS, Examination, Finding, State
from virtualrobot_sdk.testing.grade import grade, main
from virtualrobot_sdk.testing.report import text
from virtualrobot_sdk.testing.subject import Subject, locate

from tests.plugins.install import WRONG, install

pytestmark = pytest.mark.long

CHAINS = {"puma560": puma560()}

SUITES = """
from virtualrobot_sdk.testing import KinematicsContract
from virtualrobot_sdk.testing.chains import scara

class TestNobody(KinematicsContract):
    component = "good/nobody"
    chains = {"scara": scara()}

class TestDeclines(TestNobody):
    component = "good/good"
    settings = {"joints": 3}
"""

FAULTS = {
    "raises_at_work": ("inverse", r"inverse raised KeyError: 'elbow up' \(__init__\.py:\d+ in inverse\)"),
    "hangs": ("inverse", r"inverse gave no answer within 2 s"),
    "crashes": ("inverse", r"SIGSEGV"),
    "returns_nan": ("inverse", r"inverse returned nan at \[0, 5\]; all values must be finite"),
    "wrong_shape": ("inverse", r"inverse returned solutions of shape \(6,\); they must be \(m, 6\)"),
    "wrong_frame": ("forward", r"forward puts the tip 0\.1 m and \S+ rad from where the chain has it"),
    "leaks": ("memory", r"its process grows by [\d,]+ bytes a call"),
}
"""What a wrong component breaks first, and what is said about it."""


@pytest.fixture(autouse=True)
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return the folder in which all wrong plugins are installed; no process may be left at the end."""
    before = {child.pid for child in psutil.Process().children(recursive=True)}
    folder = install(tmp_path / "site", "good", *WRONG)
    monkeypatch.syspath_prepend(folder)
    yield folder
    assert {child.pid for child in psutil.Process().children(recursive=True)} <= before


def find(component: str, **settings: object) -> Subject:
    """Return a kinematics component."""
    return locate(ComponentKind.KINEMATICS, component, settings)


def found(name: str, law: str, seed: int, **settings: object) -> Finding:
    """Return what comes of one law."""
    examination = Examination(find(f"{name}/{name}", **settings), CHAINS, seed)
    try:
        return examination.examine(law, LAWS[law], "puma560")
    finally:
        examination.close()


@pytest.mark.parametrize("name", FAULTS)
def test_the_fault_is_found(name: str, seed: int) -> None:
    law, said = FAULTS[name]
    finding = found(name, law, seed, **({"bytes_a_call": 60} if name == "leaks" else {}))
    assert finding.state is State.FAILED
    assert re.search(said, finding.said), finding.said


def test_every_wrong_plugin_is_tried() -> None:
    assert {*FAULTS, "raises_on_import"} == set(WRONG)


def test_one_that_grows_too_much_is_ended(seed: int) -> None:
    finding = found("leaks", "inverse", seed, bytes_a_call=256 << 20)
    assert finding.state is State.FAILED
    assert "grew" in finding.said


def test_the_good_one_gets_a_good_grade(seed: int) -> None:
    report = grade("good/good", {"restarts": 100}, chains=CHAINS, seed=seed)
    assert report.passed, text(report)
    assert report.taken == ("puma560",)
    assert [row.law for row in report.rows] == ["made", *LAWS]
    assert {cost.method for cost in report.cost} == {"forward", "jacobian", "inverse"}
    (solutions,) = report.solutions
    assert solutions.returned == solutions.poses <= solutions.existing


def test_a_wrong_one_gets_a_bad_grade(site: Path, seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["wrong_shape/wrong_shape", "--chains", "chains_of_mine:chains", "--seed", str(seed)]
    assert main(command) == 1
    assert "'chains_of_mine:chains' cannot be imported: ModuleNotFoundError" in capsys.readouterr().err
    source = "from virtualrobot_sdk.testing.chains import scara\ndef chains():\n    return {'mine': scara()}\n"
    (site / "chains_of_mine.py").write_text(source)
    assert main(command) == 1
    printed = capsys.readouterr().out
    assert re.search(r"^inverse +failed ", printed, re.MULTILINE)
    assert re.search(r"^forward +ok +25 ", printed, re.MULTILINE)
    assert "inverse on mine: inverse returned solutions of shape (4,); they must be (m, 4)" in printed
    assert re.search(r"\nfailed: inverse, ", printed)


def test_one_with_wrong_settings_is_told_so(seed: int) -> None:
    (made,) = grade("good/good", {"restrats": 100}, chains=CHAINS, seed=seed).rows
    said = "it declines all: there is no setting 'restrats'; did you mean 'restarts'?"
    assert (made.law, made.state, made.said) == ("made", State.FAILED, {"every chain": said})


@pytest.mark.long
def test_one_whose_process_ends_again_and_again_is_not_tried_for_ever(seed: int) -> None:
    report = grade("crashes/crashes", chains=CHAINS, seed=seed)
    states = {row.law: row.state for row in report.rows}
    assert [law for law, state in states.items() if state is State.FAILED] == ["inverse", "limits", "order"]
    assert states["forward"] is State.OK
    assert states["memory"] is State.NOT_TRIED
    assert not report.passed


def test_a_suite_of_nobody_fails_once(site: Path) -> None:
    """In a pytest of its own, as an author sees it."""
    (site / "test_nobody.py").write_text(SUITES, "utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_nobody.py"]
    done = subprocess.run(command, cwd=site, capture_output=True, text=True, timeout=100)
    assert "2 failed, 30 skipped" in done.stdout, done.stdout
    assert "no kinematics 'nobody'; there are good" in done.stdout
    assert "all chains are declined:\nscara: it is made for 3 joints; this robot has 4" in done.stdout


def test_a_component_of_another_kind_is_told_apart() -> None:
    with pytest.raises(
        PluginError, match=r"no kinematics 'loopback'; there is none; 'loopback' is a robot_driver, whose"
    ):
        locate(ComponentKind.KINEMATICS, "virtualrobot_plugins.drivers/loopback", {})


@pytest.mark.long
def test_plugins_that_cannot_be_imported_are_named() -> None:
    with pytest.raises(PluginError, match=r"RuntimeError: the licence of this plugin has expired \(__init__\.py:3\)"):
        find("raises_on_import/raises_on_import")
    with pytest.raises(
        PluginError, match=r"no plugin has kinematics 'nobody'; there are .*good.*'raises_on_import' fai"
    ):
        find("nobody")


def test_a_crash_on_import_is_named(site: Path) -> None:
    install(site, "crashes_on_import")
    with pytest.raises(ComponentFault, match="SIGSEGV"):
        find("crashes_on_import/crashes_on_import")
