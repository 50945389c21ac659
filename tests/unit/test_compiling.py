"""Code is compiled by several processes, and here where they can't."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.unit.sdk.test_cache import run

SIDE_BY_SIDE = """
import json, os
from virtualrobot_kernel import compiling
from virtualrobot_sdk.compiled import cache
from virtualrobot_sdk.embree import curved
cache._compiled_functions[:] = [curved.bound, curved.occlude]
os.cpu_count = lambda: 2
calls = []
compiling.compile_side_by_side(lambda *call: calls.append(call))
here = [one.name for one in cache._compiled_functions if one._native]
print(json.dumps({"calls": calls, "here": here}))
"""


@pytest.mark.long
def test_processes_fill_the_cache_and_nothing_is_left_to_this_one(tmp_path: Path) -> None:
    calls = [[0, 2, "bound"], [1, 2, "occlude"]]
    assert run(SIDE_BY_SIDE, NUMBA_CACHE_DIR=str(tmp_path)) == {"calls": calls, "here": []}
    assert run(SIDE_BY_SIDE, NUMBA_CACHE_DIR=str(tmp_path)) == {"calls": [], "here": []}


@pytest.mark.long
def test_what_others_keep_elsewhere_is_compiled_here(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a directory")
    found = run(SIDE_BY_SIDE, NUMBA_CACHE_DIR=str(blocked / "cache"))
    assert found["here"] == ["bound", "occlude"]
