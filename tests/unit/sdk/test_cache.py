"""Where compiled code goes, and what the first and the second start report; each in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PATHS = os.pathsep.join(str(ROOT / folder) for folder in ("kernel", "plugins"))
REPORT = """
import json, os
from virtualrobot_kernel.numeric import forest
from virtualrobot_plugins.chain import serial
from virtualrobot_sdk.compiled import cache
from virtualrobot_sdk.embree import curved, packets
long_ones = [one for one in cache._compiled_functions if one.function.__module__ == packets.__name__]
cache._compiled_functions[:] = [one for one in cache._compiled_functions if one not in long_ones]
calls = []
anew = cache.compile_all(lambda done, total, name: calls.append((done, total, name)))
print(json.dumps({"calls": calls, "anew": anew, "directory": str(forest.forward_forest.directory)}))
"""
DIRECTORY = """
import json
from virtualrobot_kernel.numeric.forest import forward_forest
print(json.dumps({"directory": str(forward_forest.directory)}))
"""


def run(program: str, **environment: str) -> dict:
    """Run a program in a new process and return what it prints."""
    inherited = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**inherited, "PYTHONPATH": PATHS, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.long
def test_first_start_says_what_it_compiles_and_the_second_says_nothing(tmp_path: Path) -> None:
    first = run(REPORT, NUMBA_CACHE_DIR=str(tmp_path))
    names = [name for _, _, name in first["calls"]]
    assert {"forward_forest", "chain_frames", "chain_jacobian", "intersect"} <= set(names)
    assert [(done, total) for done, total, _ in first["calls"]] == [(i, len(names)) for i in range(len(names))]
    assert first["anew"] == names
    assert Path(first["directory"]).parent == tmp_path
    for file in tmp_path.rglob("*.nbi"):
        os.utime(file, (1, 1))  # as if the same sources had been checked out since
    second = run(REPORT, NUMBA_CACHE_DIR=str(tmp_path))
    assert second == {"calls": [], "anew": [], "directory": first["directory"]}


def test_without_a_setting_the_user_s_cache_directory_is_used(tmp_path: Path) -> None:
    directory = Path(run(DIRECTORY, XDG_CACHE_HOME=str(tmp_path), HOME=str(tmp_path))["directory"])
    assert directory.is_relative_to(tmp_path)
    assert directory.is_dir()


def test_a_place_that_cannot_be_written_gives_way_to_a_temporary_one(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a directory")
    directory = Path(run(DIRECTORY, NUMBA_CACHE_DIR=str(blocked / "cache"))["directory"])
    assert not directory.is_relative_to(tmp_path)
    assert not directory.exists()  # it went with its process


MISSING = """
import json
from virtualrobot_sdk.compiled import cache, rigid
calls = []
cache.compile_missing(lambda done, total, name: calls.append((done, total, name)))
print(json.dumps({"calls": calls, "loaded": rigid.orthonormalise._ready, "processor": cache.processor()}))
"""


@pytest.mark.long
def test_code_of_another_processor_is_compiled_anew_and_this_one_s_is_loaded_when_it_is_called(tmp_path: Path) -> None:
    first = run(MISSING, NUMBA_CACHE_DIR=str(tmp_path))
    (name,) = (name for _, _, name in first["calls"])
    assert name == "orthonormalise" and first["loaded"]
    assert run(MISSING, NUMBA_CACHE_DIR=str(tmp_path)) == {**first, "calls": [], "loaded": False}
    (index,) = tmp_path.rglob("*.nbi")
    here = first["processor"].encode()
    index.write_bytes(index.read_bytes().replace(here, here[::-1]))
    assert run(MISSING, NUMBA_CACHE_DIR=str(tmp_path)) == first
    chosen = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "+sse2"}
    generic = {**first, "processor": "generic"}
    assert run(MISSING, **chosen) == generic
    assert run(MISSING, **chosen) == {**generic, "calls": [], "loaded": False}


@pytest.mark.long
def test_threads_may_ask_for_the_same_code_at_once(tmp_path: Path) -> None:
    program = """
import json, threading
from virtualrobot_sdk.compiled import cache
from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.embree.curved import bound
cache._compiled_functions[:] = [orthonormalise, bound]
barrier, addresses, failed = threading.Barrier(6), set(), []
def ask():
    barrier.wait()
    try:
        make_ready()
        addresses.add(bound.address)
    except Exception as error:
        failed.append(repr(error))
threads = [threading.Thread(target=ask) for _ in range(6)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
print(json.dumps({"addresses": len(addresses), "failed": failed}))
"""
    assert run(program, NUMBA_CACHE_DIR=str(tmp_path)) == {"addresses": 1, "failed": []}
