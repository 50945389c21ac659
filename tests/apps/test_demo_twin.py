"""`virtualrobot demo twin`: emulated controllers follow their twins, and what would collide is not sent."""

from __future__ import annotations

import re
import signal
from pathlib import Path

import pytest

from tests.apps.test_demo_command import lines_until, started_demo
from tests.waiting import until

pytestmark = pytest.mark.long


def numbers(row: str) -> tuple[str, list[float]]:
    """Return the driver in a row of the table, and the numbers after it."""
    _, driver, *rest = row.split()
    return driver, [float(word) for word in rest if word != "mrad"]


@pytest.mark.timeout(600)
def test_it_stacks_boxes_refuses_and_goes_on() -> None:
    with started_demo("twin", "--headless") as process:
        output, _ = process.communicate(timeout=570)
    assert process.returncode == 0, output
    assert "viewer at" not in output
    refused = re.search(r"^ur refuses: a real robot would play this, and nothing was sent: 'ur\.", output, re.MULTILINE)
    stood = re.search(r"^ur stood still: it moved by ([\d.]+) mrad$", output, re.MULTILINE)
    assert refused and stood and "'carton'" in output, output
    assert float(stood[1]) < 1.0, "an arm at rest settles by less"
    assert refused.start() < output.index("the carton is taken away") < output.index("box 2 of 3"), output
    *_, ur, abb = output.splitlines()
    for row, driver, refusals in (ur, "ur_rtde", 1), (abb, "abb_egm", 0):
        said, (boxes, sent, refused_orders, setpoints, mean, most) = numbers(row)
        assert (said, boxes, refused_orders) == (driver, 3, refusals), output
        assert sent >= 4, "three boxes and the way home; more where robots had to brake"
        assert setpoints > 0 and 0.0 < mean <= most <= 250.0, output


@pytest.mark.timeout(600)
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="reads processes from /proc")
def test_an_interrupt_leaves_no_process_behind() -> None:
    with started_demo("twin", "--headless") as process:
        lines = "\n".join(lines_until(process, "box 1 of"))
        below = descendants(process.pid)
        assert set(map(int, re.findall(r"process (\d+)", lines))) < below, lines
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=300)
    assert process.returncode == 130, output
    assert "Traceback" not in output and output.split()[-1] == "stopped", output
    until(lambda: not any(Path(f"/proc/{one}").exists() for one in below))


def descendants(process: int) -> set[int]:
    """Return the numbers of all processes below one: the kernel, its drivers, the controllers."""
    found: set[int] = set()
    for task in Path(f"/proc/{process}/task").glob("*/children"):
        for child in map(int, task.read_text().split()):
            found |= {child} | descendants(child)
    return found
