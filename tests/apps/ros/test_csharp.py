"""The program in C# of docs/unity.md, compiled and run by Mono."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge

pytestmark = pytest.mark.long

PAGE = Path(__file__).parents[3] / "docs" / "unity.md"
MCS, MONO = shutil.which("mcs"), shutil.which("mono")
needs_mono = pytest.mark.skipif(
    MCS is None or MONO is None, reason="no Mono: tools/install_toolchains.sh installs Debian's mono-mcs"
)


def ended(*command: str | None, folder: Path) -> list[str]:
    """Return the lines that a program prints; one that fails fails the test with its words."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=GUARD)
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"
    return done.stdout.splitlines()


@needs_mono
def test_the_program_of_the_page_hears_asks_and_drives(client: Client, tmp_path: Path) -> None:
    found = re.search(r"```csharp\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert found
    (tmp_path / "drive.cs").write_text(found[1], "utf-8")
    ended(MCS, "drive.cs", folder=tmp_path)
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    client.load_robot("model://ugv", base="planar")
    with bridge(client) as (url, _):
        joints, answer, last = ended(MONO, "drive.exe", url, folder=tmp_path)
    told = json.loads(joints)["msg"]
    assert (told["name"], told["position"]) == (arm.joint_names, arm.positions.tolist())
    assert json.loads(answer)["values"] == {"value": '"arm"'}
    assert last == "driven"
    assert client.streams.sample("/robots/ugv/base").values["x"] > 0.1
