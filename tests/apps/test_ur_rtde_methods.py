"""Every public method of ur-rtde against the emulated controller: as its page says, line by line."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import rtde_control
import rtde_io
import rtde_receive

from tests.apps.ur_programs import DEADLINE
from tests.drivers.ur_controllers import ControllerProcess, host

PAGE = (Path(__file__).parents[2] / "docs" / "ur-rtde-methods.md").read_text("utf-8")
CLASSES = {
    "rtde_control": rtde_control.RTDEControlInterface,
    "rtde_receive": rtde_receive.RTDEReceiveInterface,
    "rtde_io": rtde_io.RTDEIOInterface,
}
RUN = """
import json, sys

for name, refused, code in json.loads(sys.argv[1]):
    try:
        value = eval(code)
    except Exception as error:
        value = f"raises {error!r}"
    print(json.dumps([name, value if isinstance(value, (bool, str)) else repr(value)]), flush=True)
    if refused:
        soon(lambda: not control.isProgramRunning())
        control.disconnect()
        control.reconnect()
        soon(control.isProgramRunning)
"""


class Row(NamedTuple):
    """A row of the page: the module, the method, what works of it here, and the line that tries it."""

    module: str
    method: str
    here: str
    code: str


def rows() -> list[Row]:
    """Return the rows of the page."""
    found = []
    for section in PAGE.split("\n## ")[1:]:
        module = re.match(r"\w+", section)
        assert module is not None
        found += [Row(module[0], *row) for row in re.findall(r"^\| `(\w+)` \| (.+?) \| `(.+)` \|$", section, re.M)]
    return found


def test_the_page_has_each_public_method_once() -> None:
    for module, kind in CLASSES.items():
        public = {
            name
            for name in dir(kind)
            if not name.startswith("_") and callable(getattr(kind, name)) and name[0].islower()
        }
        assert sorted(row.method for row in rows() if row.module == module) == sorted(public)
    kinds = {row.here.partition(",")[0].partition(";")[0] for row in rows()}
    assert kinds == {"works", "0", "refused", "the library's"}
    assert not [row for row in rows() if f".{row.method}" not in row.code]


@pytest.mark.long
def test_each_method_does_what_the_page_says() -> None:
    process = ControllerProcess(host=host(1))
    try:
        head = re.search(r"```python\n(.*?)```", PAGE, re.S)
        assert head is not None
        program = head[1].replace("127.0.0.1", process.host) + RUN
        asked = json.dumps([(row.method, row.here.startswith("refused"), row.code) for row in rows()])
        done = subprocess.run(
            [sys.executable, "-c", program, asked], capture_output=True, text=True, timeout=5 * DEADLINE
        )
        assert done.returncode == 0, done.stdout + done.stderr
    finally:
        said = process.kill()
    values = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("[")]
    assert [name for name, _ in values] == [row.method for row in rows()]
    for row, (_, value) in zip(rows(), values, strict=True):
        if not row.here.startswith("refused"):
            assert value is True, (row, value)
            continue
        how, _, words = row.here.removeprefix("refused, ").partition(": ")
        assert how in ("False", "raises", "unawaited") and words
        assert value is False if how == "False" else how == "unawaited" or str(value).startswith("raises"), (row, value)
        said = said[said.index(words) + len(words) :]
