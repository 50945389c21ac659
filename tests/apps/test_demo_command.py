"""`virtualrobot demo`, which is what `make run` runs: a child process from its start to its end."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import av
import pytest

from tests.tiers import every_fifth


@contextmanager
def started(speed: float, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Give the running command, so much faster than the wall clock."""
    with started_demo("--headless", "--speed", str(speed), *options) as process:
        yield process


@contextmanager
def started_demo(*options: str) -> Iterator[subprocess.Popen[str]]:
    """Give the running command, in a process group of its own as a terminal's are."""
    command = [sys.executable, "-m", "virtualrobot", "demo", *options]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def lines_until(process: subprocess.Popen[str], beginning: str) -> list[str]:
    """Return what the command prints until a line begins so."""
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip())
        if line.startswith(beginning):
            return lines
    raise AssertionError(f"it ended before {beginning!r}: {lines}")


@pytest.mark.timeout(600)
@pytest.mark.long
def test_it_goes_on_in_its_folder_after_it_was_killed(tmp_path: Path) -> None:
    for boxes in (3, 8):
        with started(25, "--data", str(tmp_path / "cell")) as process:
            lines = lines_until(process, f"box {boxes:2} of 36: ")
            os.kill(int((tmp_path / "cell" / "lock").read_text()), signal.SIGKILL)
            process.communicate(timeout=280)
            assert process.returncode == 1
    with started(25, "--data", str(tmp_path / "cell")) as process:
        output, _ = process.communicate(timeout=280)
    assert process.returncode == 0, output
    assert re.search(
        rf"^going on: ({boxes}|{boxes + 1}|{boxes + 2}) of 36 boxes are on their pallets$", output, re.M
    ), lines
    assert f"box  {boxes} of 36" not in output and "box 36 of 36: " in output, lines
    command = [sys.executable, "-m", "virtualrobot", "replay", str(tmp_path / "cell"), "--verify"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)
    assert told.returncode == 0, told.stdout + told.stderr
    assert re.search(r"^[1-9]\d* ticks are the same", told.stdout, re.MULTILINE), told.stdout


@pytest.mark.timeout(300)
@pytest.mark.long
def test_it_runs_to_its_end() -> None:
    with started(25) as process:
        output, _ = process.communicate(timeout=280)
    assert process.returncode == 0, output
    assert "viewer at" not in output
    assert [int(number) for number in re.findall(r"^box +(\d+) of 36: ", output, re.MULTILINE)] == list(range(1, 37))
    *_, iiwa, panda, total = output.splitlines()
    assert re.match(r"iiwa +18 ", iiwa) and re.match(r"panda +18 ", panda), output
    assert re.fullmatch(r"total +36 in [\d.]+ s of simulation time", total), output


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="reads child processes from /proc")
@pytest.mark.parametrize("sign", every_fifth([signal.SIGINT, signal.SIGTERM]))
def test_an_interrupt_ends_it_and_its_kernel(sign: signal.Signals) -> None:
    with started(10, "--loop") as process:
        lines = lines_until(process, "box  1 of")
        assert any(re.fullmatch(r"kernel at 127\.0\.0\.1:\d+", line) for line in lines), lines
        (kernel,) = children(process.pid)
        process.send_signal(sign)
        output, _ = process.communicate(timeout=60)
        assert process.returncode == 130, output
        assert "Traceback" not in output
        assert output.split()[-1] == "stopped"
        assert not Path(f"/proc/{kernel}").exists(), "the kernel runs on"


@pytest.mark.long
def test_a_film_of_it_opens_though_it_is_interrupted(tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    with started(5, "--record", str(film)) as process:
        lines_until(process, "box  3 of")
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=60)
    assert (process.returncode, "Traceback" in output) == (130, False), output
    with av.open(str(film)) as opened:
        frames = [frame.to_ndarray(format="rgb24") for frame in opened.decode(video=0)]
    assert frames, "how many are drawn by then is the machine's affair"
    assert frames[0].shape == (720, 1280, 3)
    assert frames[-1].std() > 20.0, "there is something to see"


@pytest.mark.long
def test_it_says_in_one_line_why_it_ends_when_its_kernel_is_killed() -> None:
    if not Path("/proc/self/task").exists():
        pytest.skip("reads child processes from /proc")
    with started(10) as process:
        lines_until(process, "box  1 of")
        (kernel,) = children(process.pid)
        os.kill(kernel, signal.SIGKILL)
        output, _ = process.communicate(timeout=60)
        assert process.returncode == 1, output
        assert "Traceback" not in output
        assert output.splitlines()[-1].startswith("virtualrobot: no kernel answers at "), output


def children(process: int) -> list[int]:
    """Return the process numbers of the children of a process."""
    tasks = Path(f"/proc/{process}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]
