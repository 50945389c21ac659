"""`virtualrobot plugins`, `kinematics`, `models` and `export`, and settings of models, on a real kernel."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run

# An arm in a plane: two joints that turn about parallel axes, half a meter apart.
ROWS = [(0.5, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0)]
XACRO = """<robot name="stand" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <link name="$(arg prefix)column"/>
</robot>
"""
SRDF = '<robot name="stand"><group name="all"><link name="7column"/></group></robot>'


def test_plugins_are_shown_with_their_components(run: Run, iiwa: Robot) -> None:
    iiwa.solve_inverse(iiwa.tcp)
    shown = run("plugins")
    assert re.search(r"^\w+ \S+ \(virtualrobot\)  loaded$", shown, re.MULTILINE)
    assert re.search(r"^  kinematics +arm_angle +in process .*\n    for iiwa: ", shown, re.MULTILINE)
    assert re.search(r"^  importer +xacro +process, 20 s a call +\.xacro", shown, re.MULTILINE)
    assert "arguments: object" not in shown
    assert "    arguments: object" in run("plugins", "--settings", "--reload")


def test_kinematics_are_shown_and_swapped(run: Run, client: Client, iiwa: Robot) -> None:
    assert run("kinematics", "iiwa") == "arm_angle\n"
    check = run("kinematics", "iiwa", "chain")
    assert re.fullmatch(
        r"\d+ postures .*\nforward .* m .* rad .* ms\ninverse .* m .* rad .* ms\njacobian, relative .* ms\n", check
    ), check
    client.load_denavit_hartenberg(ROWS, convention="standard", name="plane")
    shown = run("kinematics", "plane")
    assert shown.startswith("dh\n  convention = standard\n")
    assert '  rows = [{"a_meters": 0.5' in shown
    run("kinematics", "plane", "chain")
    run("kinematics", "plane", "dh", "--set", "convention=modified", "--set", "rows=[{}, {}]", code=1)
    assert client.robot("plane").kinematics == "chain"
    rows = 'rows=[{"a_meters": 0.5}, {"a_meters": 0.4}]'
    assert "postures" in run("kinematics", "plane", "dh", "--set", "convention=standard", "--set", rows)
    assert client.robot("plane").kinematics == "dh"
    # Without a component its own is made anew, with these settings alone.
    assert "'rows'" in run("kinematics", "plane", "--set", "convention=standard", code=1)


def test_kinematics_that_are_not_there_are_one_line(run: Run, iiwa: Robot) -> None:
    assert "did you mean 'chain'" in run("kinematics", "iiwa", "chian", code=1)
    assert "did you mean 'iiwa'" in run("kinematics", "iwa", code=1)
    assert "has no settings; 'gain' was given" in run("kinematics", "iiwa", "chain", "--set", "gain=1", code=1)


def test_a_known_model_is_loaded_and_exported(run: Run, client: Client, tmp_path: Path) -> None:
    assert re.search(r"^puma560 +Unimation Puma 560", run("models"), re.MULTILINE)
    heads, *rows = run("models", "--search", "arm 1200", "--maker", "abb").splitlines()
    assert heads.split() == ["name", "model", "axes", "payload", "reach", "comes", "with"]
    assert [row.split()[0] for row in rows] == ["irb1200_5_90", "irb1200_7_70"] and "5 kg  0.901 m" in rows[0]
    assert run("models", "--search", "nothing of the kind") == "the kernel knows no such model\n"
    assert run("load", "model://puma560", "--name", "puma") == "loaded robot puma\n"
    file = tmp_path / "out" / "puma.urdf"
    file.parent.mkdir()
    assert run("export", "puma", str(file)).startswith(f"exported puma to {file}")
    run("load", str(file), "--name", "again")
    puma, again = client.robot("puma"), client.robot("again")
    q = {name: 0.3 for name in puma.joint_names}
    np.testing.assert_allclose(again.solve_forward(q).world_t_tcp, puma.solve_forward(q).world_t_tcp, atol=1e-9)
    assert "valid: .glb, .urdf" in run("export", "puma", str(tmp_path / "puma.stl"), code=1)


@pytest.fixture
def stand(tmp_path: Path) -> str:
    """Return the path of a xacro file with an argument, beside an SRDF file."""
    (tmp_path / "stand.srdf").write_text(SRDF)
    (tmp_path / "stand.xacro").write_text(XACRO)
    return str(tmp_path / "stand.xacro")


def test_a_model_is_loaded_with_settings(run: Run, client: Client, stand: str) -> None:
    srdf = str(Path(stand).with_suffix(".srdf"))
    # The importer's schema says that arguments are text, so that 7 need not stand in quotes.
    assert run("load", stand, "--set", "arguments.prefix=7", "--srdf", srdf) == "loaded robot stand\n"
    assert client.robot("stand").links == ["stand.7column"]
    assert list(client.robot("stand").groups) == ["all"]
    assert "did you mean 'arguments.prefix'" in run("load", stand, "--set", "prefix=7", code=1)


def test_what_is_odd_about_a_model_is_shown(run: Run, stand: str) -> None:
    shown = run("load", stand, "--name", "odd", "--set", "arguments.prefx=7", warns=1)
    assert shown.startswith("loaded robot odd\nwarning: ")
    assert "did you mean 'prefix'" in shown
