"""The TypeScript client of clients/node: built by npm, then run against a real kernel that wants its token."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess

from tests.apps.test_languages import PRINTED

ROOT = Path(__file__).resolve().parent.parent.parent
CLIENT = ROOT / "clients" / "node"
PAGE = ROOT / "docs" / "tutorial-node.md"
NODE, NPM = shutil.which("node"), shutil.which("npm")
OLDEST_NODE = 20
JOINTS = [f"lbr_iiwa_joint_{number}" for number in range(1, 8)]
ROUNDED = 1e-6
"""The program prints six decimals."""


def node_version() -> int:
    """Return the major version of Node.js, 0 when it or npm is missing."""
    if NODE is None or NPM is None:
        return 0
    said = subprocess.run([NODE, "--version"], capture_output=True, text=True, check=True).stdout
    return int(said.removeprefix("v").partition(".")[0])


needs_node = pytest.mark.skipif(
    node_version() < OLDEST_NODE, reason=f"the TypeScript client needs node {OLDEST_NODE} or later, and npm"
)
pytestmark = pytest.mark.long  # installs from the network


def npm(*arguments: str) -> None:
    """Run npm in the client's folder; fail with what it has said."""
    assert NPM is not None
    done = subprocess.run([NPM, *arguments], cwd=CLIENT, capture_output=True, text=True)
    assert done.returncode == 0, f"npm {' '.join(arguments)}:\n{done.stdout}{done.stderr}"


@pytest.fixture(scope="module")
def program() -> list[str]:
    """Return the command of the built program; the build makes stubs of today's contract and checks all types."""
    lock, installed = CLIENT / "package-lock.json", CLIENT / "node_modules" / ".package-lock.json"
    if not installed.exists() or installed.stat().st_mtime < lock.stat().st_mtime:
        npm("ci", "--no-fund", "--no-audit")
        installed.touch()
    npm("run", "build")
    assert NODE is not None
    return [NODE, str(CLIENT / "dist" / "cell.js")]


@dataclass
class Cell:
    """A kernel with its token, and a Python client of it."""

    client: virtualrobot.Client
    environment: dict[str, str]

    def run(self, program: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
        """Run the program to its end."""
        where = self.environment | environment
        return subprocess.run(program, env=where, capture_output=True, text=True, timeout=60)


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cell]:
    """Return a kernel of this file's own."""
    token_file = tmp_path_factory.mktemp("token") / "token"
    with KernelProcess("--token-file", str(token_file), headless=True) as kernel:
        token = token_file.read_text("utf-8").strip()
        environment = {"VIRTUALROBOT_ADDRESS": kernel.address, "VIRTUALROBOT_TOKEN": token}
        with virtualrobot.connect(kernel.address, token=token) as client:
            yield Cell(client, os.environ | environment)


@pytest.fixture(scope="module")
def output(cell: Cell, program: list[str]) -> str:
    """Return what a run prints; the arm stands as it left it."""
    cell.client.clock.set_realtime(0.5)  # enough states for the watch on a busy machine too
    done = cell.run(program)
    cell.client.clock.set_realtime(1.0)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr
    return done.stdout


def numbers(text: str) -> np.ndarray:
    """Return the numbers of a printed row."""
    return np.array([float(word) for word in text.split()])


def printed(output: str, label: str) -> str:
    """Return the rest of the one line that begins with `label: `."""
    (found,) = re.findall(rf"^{label}: (.*)$", output, re.MULTILINE)
    return found


@needs_node
def test_it_reads_the_joints_that_python_reads(cell: Cell, output: str) -> None:
    arm = cell.client.robot("arm")
    assert list(arm.joint_names) == JOINTS
    np.testing.assert_allclose(numbers(printed(output, "joints")), arm.positions, rtol=0, atol=ROUNDED)


@needs_node
def test_the_arm_ends_where_the_program_sends_it(output: str) -> None:
    """At (0.5, 0.1, 0.5) it points down, half a turn about x, and then goes 0.1 m along that: by hand z = 0.4."""
    row = numbers(printed(output, "flange"))
    np.testing.assert_allclose(row[:3], [0.5, 0.1, 0.4], rtol=0, atol=1e-3)
    np.testing.assert_allclose(np.abs(row[3:]), [1, 0, 0, 0], rtol=0, atol=np.radians(0.1))


@needs_node
def test_its_watch_sees_the_arm_move_in_the_order_of_ticks(output: str) -> None:
    rows = re.findall(r"^tick (\d+): (.*)$", output, re.MULTILINE)
    ticks = [int(tick) for tick, _ in rows]
    assert all(before < after for before, after in pairwise(ticks)), ticks
    states = np.array([numbers(row) for _, row in rows])
    assert not states[0].any(), "a watch begins with the state as it is: at zero"
    assert len(np.unique(states, axis=0)) > 3
    first = np.array([0, 0.5, 0, -1.2, 0, 0.8, 0])  # the first goal of the program
    along = states[(states[:, 0] == 0) & (states[:, 1] > 0)]
    assert len(along) > 0
    np.testing.assert_allclose(
        along, np.outer(along[:, 1] / 0.5, first), atol=1e-5, err_msg="PTP is straight in joints"
    )


@needs_node
def test_it_tells_why_a_misspelt_joint_is_refused(output: str) -> None:
    refused = printed(output, "refused")
    assert refused.startswith("NOT_FOUND UNKNOWN_NAME: ")
    assert "named 'lbr_iiwa_jiont_4'; did you mean 'lbr_iiwa_joint_4'" in refused
    assert printed(output, "nearest") == "lbr_iiwa_joint_4"


@needs_node
@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ({"VIRTUALROBOT_TOKEN": "wrong"}, ("UNAUTHENTICATED: ", "authorization: Bearer")),
        ({"VIRTUALROBOT_TOKEN": ""}, ("UNAUTHENTICATED: ", "authorization: Bearer")),
        ({"VIRTUALROBOT_ADDRESS": "127.0.0.1:1"}, ("UNAVAILABLE", "127.0.0.1:1")),
    ],
    ids=["wrong token", "no token", "no kernel"],
)
def test_it_ends_with_one_line_when_it_gets_no_answer(
    cell: Cell, program: list[str], environment: dict[str, str], words: tuple[str, ...]
) -> None:
    done = cell.run(program, **environment)
    assert (done.returncode, done.stdout) == (1, "")
    (line,) = done.stderr.splitlines()
    assert all(word in line for word in words), line


@needs_node
def test_it_hears_that_somebody_stops_its_motion(cell: Cell, program: list[str], output: str) -> None:
    assert printed(output, "joints"), "the arm is in the world"
    cell.client.scene.remove("arm")
    cell.client.speed_factor = 0.05  # half a second becomes ten, so that it can be stopped on its way
    with subprocess.Popen(
        program, env=cell.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        next(line for line in process.stdout if numbers(line.partition(": ")[2]).any())
        (motion,) = cell.client.stop("arm")
        _, said = process.communicate(timeout=60)
    cell.client.speed_factor = 1.0
    assert process.returncode == 1
    assert re.fullmatch(rf"Error: motion {re.escape(motion.id)} is CANCELLED: .+\n", said), said


def unindented(text: str) -> str:
    """Return the lines of a text without the spaces that they begin with."""
    return "\n".join(line.lstrip() for line in text.splitlines())


def test_the_tutorial_shows_the_program_as_it_is() -> None:
    sources = [unindented(file.read_text("utf-8")) for file in (CLIENT / "src").glob("*.ts")]
    shown = re.findall(r"^```ts\n(.*?)^```$", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert len(shown) > 3
    assert [block for block in shown if not any(unindented(block) in source for source in sources)] == []


@needs_node
def test_it_picks_as_programs_in_other_languages_do(cell: Cell, program: list[str]) -> None:
    node, main = program
    done = cell.run([node, str(Path(main).with_name("pick.js")), str(ROOT / "clients" / "cell.yaml")])
    assert (done.returncode, done.stderr, done.stdout) == (0, "", PRINTED)
