"""Connect's own clients of npm call a console by each protocol that they know, in bytes and in JSON."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
import virtualrobot

from tests.api.asking import IIWA
from tests.apps.console.consoles import PATIENCE_SECONDS, consoles
from tests.apps.test_node_client import needs_node
from tests.kernels import StartKernel

HERE = Path(__file__).parent / "connect"
ROOT = Path(__file__).parents[3]


def run(folder: Path, *command: str) -> str:
    """Run a command in a folder and return what it prints; fail with all that it says."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_SECONDS)
    assert done.returncode == 0, f"{' '.join(command)}:\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.mark.long  # installs from the network
@needs_node
def test_connect_and_grpc_web_by_their_own_clients(start_kernel: StartKernel, tmp_path: Path) -> None:
    folder = tmp_path / "connect"
    shutil.copytree(HERE, folder, ignore=shutil.ignore_patterns("node_modules", "generated"))
    shutil.copytree(ROOT / "proto", folder / "proto")
    shutil.copytree(ROOT / "clients" / "node" / "proto", folder / "google")
    run(folder, "npm", "ci", "--no-fund", "--no-audit")
    run(folder, str(ROOT / "node_modules" / ".bin" / "buf"), "generate")
    kernel = start_kernel(token=True)
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        consoles(kernel.address, token=kernel.token) as console,
    ):
        client.load_robot(IIWA, name="arm")
        said = run(folder, "node", "check.mjs", console.url, kernel.token).splitlines()
    # Real time; one robot; NOT_FOUND with its reason; DEADLINE_EXCEEDED; browsers send no streams.
    asked = "; 1; 1; 5 UNKNOWN_NAME virtualrobot; 4; "
    node = ["connect-node", "connect-node, JSON", "grpc-web-node"]
    web = ["connect-web", "connect-web, JSON", "grpc-web", "grpc-web, JSON"]
    assert said == [*(name + asked + "3" for name in node), *(name + asked for name in web)]
