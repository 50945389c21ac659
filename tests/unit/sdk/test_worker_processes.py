"""The worker process: what it prints, starts and leaves behind, and plugins loaded in it."""

from __future__ import annotations

import logging
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, PluginError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.worker import Worker
from virtualrobot_sdk.worker.process import LOG_BYTES

from tests.unit.sdk.worker_helpers import CASES, MIB, call, fault_of, is_gone
from tests.waiting import until


@pytest.fixture
def worker() -> Iterator[Worker]:
    with Worker("arm", memory_limit_bytes=100 * MIB) as it:
        it.make_from(CASES)
        yield it


class TestPrinting:
    def test_what_is_printed_reaches_the_log_and_breaks_nothing(
        self, worker: Worker, caplog: pytest.LogCaptureFixture
    ) -> None:
        assert call(worker, "talk") == "done"
        assert call(worker, "listen") == b""
        worker.close()
        lines = "\n".join(r.getMessage() for r in caplog.records if r.name == "virtualrobot_sdk.worker").splitlines()
        for said in (
            "printed by Python",
            "written to descriptor 1",
            "put by C",
            "echoed by a process",
            "an error line",
        ):
            assert f"arm: {said}" in lines

    def test_a_flood_neither_blocks_nor_fills_the_log(self, worker: Worker, caplog: pytest.LogCaptureFixture) -> None:
        with caplog.at_level(logging.WARNING, "virtualrobot_sdk.worker"):
            assert call(worker, "flood", 20_000) == 20_000
            worker.close()
        lines = "\n".join(r.getMessage() for r in caplog.records).splitlines()
        logged = [line for line in lines if "left out" not in line]
        assert logged[:100] == [f"arm: {i} " + "x" * 1000 for i in range(100)]
        left_out = [
            int(count) for count in re.findall(r"^arm: \(([\d]+) lines", "\n".join(lines).replace(",", ""), re.M)
        ]
        assert len(logged) + sum(left_out) == 20_000
        assert sum(map(len, logged)) < 20 * LOG_BYTES  # 20 MB were printed; a busy machine takes some seconds for them


class TestProcesses:
    def test_a_forked_copy_does_not_answer(self, worker: Worker) -> None:
        assert call(worker, "fork") == 1
        assert call(worker, "add", 1, 1) == 2

    def test_what_it_started_ends_with_it(self, worker: Worker) -> None:
        pid = call(worker, "start_a_child")
        assert isinstance(pid, int)
        fault_of(worker, "crash")
        until(lambda: is_gone(pid))

    @pytest.mark.parametrize("way", ["closed", "killed"])
    def test_what_it_started_in_a_session_of_its_own_ends_with_it(self, worker: Worker, way: str) -> None:
        pid = call(worker, "start_a_child", True)
        assert isinstance(pid, int)
        if way == "closed":
            worker.close()
        else:
            fault_of(worker, "hang", seconds=0.1)
        until(lambda: is_gone(pid))

    def test_ctrl_c_does_not_end_it(self, worker: Worker) -> None:
        assert worker.pid is not None
        os.kill(worker.pid, signal.SIGINT)
        assert call(worker, "add", 1, 1) == 2

    def test_closing_leaves_no_process_and_no_thread(self) -> None:
        before = set(threading.enumerate())
        worker = Worker("closed")
        worker.make_from(CASES)
        pid = worker.pid
        worker.close()
        worker.close()
        assert set(threading.enumerate()) == before
        assert is_gone(pid)
        assert "was closed" in fault_of(worker, "add", 1, 1).reason

    def test_closing_ends_a_call_that_hangs(self) -> None:
        before = set(threading.enumerate())
        worker = Worker("hanging")
        worker.make_from(CASES)
        pid = worker.pid
        faults: list[ComponentFault] = []
        caller = threading.Thread(target=lambda: faults.append(fault_of(worker, "hang")))
        caller.start()
        until(lambda: worker._asking.locked())
        worker.close()
        caller.join()
        assert [f.reason for f in faults] == ["worker 'hanging' was closed"]
        assert is_gone(pid)
        assert set(threading.enumerate()) == before

    def test_a_worker_that_was_never_asked_starts_nothing(self) -> None:
        with Worker("idle") as worker:
            assert worker.pid is None

    @pytest.mark.parametrize("hangs", [False, True])
    def test_it_ends_with_its_parent(self, hangs: bool, tmp_path: Path) -> None:
        marker = tmp_path / "hanging"
        work = f"w.call('hang_from', {str(marker)!r}, deadline_seconds=1000)" if hangs else "signal.pause()"
        with _parent(work) as parent:
            pid = _first_number(parent)
            until(lambda: marker.exists() or not hangs)
            assert not is_gone(pid)
            parent.kill()
        until(lambda: is_gone(pid))

    def test_native_code_that_hangs_is_ended_by_its_fuse_when_the_parent_is_gone(self, tmp_path: Path) -> None:
        shorter = (
            "from tests.unit.sdk.worker_cases import Cases\n"
            "from virtualrobot_sdk.worker import child\n"
            "child.FUSE_SECONDS = 0.5\n"
        )
        (tmp_path / "short_fuse.py").write_text(shorter, encoding="utf-8")
        with _parent("w.call('hang_in_native_code', deadline_seconds=0.5)", "short_fuse:Cases", tmp_path) as parent:
            pid = _first_number(parent)
            parent.kill()
        until(lambda: is_gone(pid))

    def test_a_parent_that_forgets_to_close_leaves_nothing(self) -> None:
        with _parent("") as parent:
            pid = _first_number(parent)
            assert parent.wait() == 0
        assert is_gone(pid)

    def test_ctrl_c_in_a_call_ends_the_process_and_the_worker(self, tmp_path: Path) -> None:
        marker = tmp_path / "hanging"
        work = (
            "try:\n"
            f"    w.call('hang_from', {str(marker)!r}, deadline_seconds=1000)\n"
            "except KeyboardInterrupt:\n"
            "    print(w.fault)\n"
        )
        with _parent(work) as parent:
            pid = _first_number(parent)
            until(marker.exists)
            parent.send_signal(signal.SIGINT)
            assert parent.stdout is not None
            assert parent.stdout.read().strip() == "hang_from was interrupted"
        assert is_gone(pid)


def _parent(work: str, path: str = CASES, folder: Path = Path()) -> subprocess.Popen[str]:
    """Start a program that has a worker, prints the number of its process and does `work`."""
    program = f"""
import signal, sys
sys.path[:] = {[*sys.path, str(folder)]!r}
signal.signal(signal.SIGINT, signal.default_int_handler)
from virtualrobot_sdk.worker import Worker
w = Worker("of another parent")
w.make_from({path!r})
print(w.pid, flush=True)
{work}
"""
    return subprocess.Popen([sys.executable, "-W", "error", "-c", program], stdout=subprocess.PIPE, text=True)


def _first_number(parent: subprocess.Popen[str]) -> int:
    assert parent.stdout is not None
    return int(parent.stdout.readline())


PLUGIN = '''
from dataclasses import dataclass
from typing import Annotated
import msgspec
from virtualrobot_sdk.hookspecs import hookimpl
from virtualrobot_sdk.registration import Isolation

api_version = "1.0"

@dataclass(frozen=True)
class Settings:
    gain: Annotated[float, msgspec.Meta(gt=0)] = 1.0

class Arm:
    """An arm that multiplies."""
    def __init__(self, chain, settings):
        self.chain, self.settings = chain, settings
    def forward(self, q):
        return q * self.settings.gain

def read():
    """Reads nothing."""
    return 1

@hookimpl
def virtualrobot_register_kinematics(register):
    register("arm", Arm, Settings, isolation=Isolation.IN_PROCESS, deadline_seconds=0.5)

@hookimpl
def virtualrobot_register_importers(register):
    register("step", read, (".stp", ".step"))
'''


class TestPlugins:
    @pytest.fixture
    def entry_point(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], EntryPoint]:
        monkeypatch.syspath_prepend(tmp_path)

        def write(text: str) -> EntryPoint:
            (tmp_path / "foreign_plugin.py").write_text(text, encoding="utf-8")
            return EntryPoint("foreign", "foreign_plugin", ENTRY_POINT_GROUP)

        return write

    def test_a_plugin_is_described_without_being_imported_here(self, entry_point: Callable[[str], EntryPoint]) -> None:
        with Worker("foreign") as worker:
            found = worker.describe(entry_point(PLUGIN))
        assert "foreign_plugin" not in sys.modules
        assert found.api_version == "1.0"
        arm, step = found.components
        assert (arm.kind, arm.name, arm.description) == (ComponentKind.KINEMATICS, "arm", "An arm that multiplies.")
        assert (arm.isolation, arm.deadline_seconds, arm.endings) == (Isolation.IN_PROCESS, 0.5, ())
        assert arm.settings_schema["properties"]["gain"] == {"type": "number", "exclusiveMinimum": 0, "default": 1.0}
        assert (step.kind, step.name, step.description) == (ComponentKind.IMPORTER, "step", "Reads nothing.")
        assert (step.isolation, step.deadline_seconds, step.endings) == (Isolation.PROCESS, 60.0, (".stp", ".step"))
        assert step.settings_schema == {}

    def test_a_component_is_made_with_its_settings(self, entry_point: Callable[[str], EntryPoint]) -> None:
        plugin = entry_point(PLUGIN)
        with Worker("foreign") as worker:
            worker.make(plugin, ComponentKind.KINEMATICS, "arm", {"gain": 2}, "the chain")
            assert call(worker, "forward", 3.0) == 6.0
            assert call(worker, "chain") == "the chain"
            with pytest.raises(ArgumentError, match="setting 'gain' is -1; it must be a number > 0"):
                worker.make(plugin, ComponentKind.KINEMATICS, "arm", {"gain": -1}, "the chain")
            with pytest.raises(PluginError, match="has no kinematics 'leg'; it has arm"):
                worker.make(plugin, ComponentKind.KINEMATICS, "leg", {})

    def test_an_import_that_raises_is_a_plugin_error_with_its_line(
        self, entry_point: Callable[[str], EntryPoint], caplog: pytest.LogCaptureFixture
    ) -> None:
        with Worker("foreign") as worker:
            with pytest.raises(PluginError, match=r"KeyError: 'x' \(foreign_plugin.py:2\)"):
                worker.describe(entry_point("\n{}['x']\n"))
            assert worker.fault is None
        assert "Traceback" in caplog.text

    def test_an_import_that_hangs_or_crashes_is_a_fault(self, entry_point: Callable[[str], EntryPoint]) -> None:
        with Worker("foreign") as worker, pytest.raises(ComponentFault) as raised:
            worker.describe(entry_point("import time; time.sleep(1000)"), deadline_seconds=0.3)
        assert raised.value.kind is FaultKind.HUNG
        assert raised.value.reason == "importing foreign_plugin gave no answer within 0.3 s"
        with Worker("foreign") as worker, pytest.raises(ComponentFault) as raised:
            worker.describe(entry_point("import ctypes; ctypes.string_at(0)"))
        assert raised.value.kind is FaultKind.DIED
        assert raised.value.reason == "its process ended with SIGSEGV in importing foreign_plugin"

    def test_a_factory_that_cannot_be_found_is_a_plugin_error(self) -> None:
        with Worker("factories") as worker:
            for path, said in {
                "tests.unit.sdk.worker_cases": "write module:attribute",
                "no_such_module:x": "No module named 'no_such_module'",
                "tests.unit.sdk.worker_cases:Nothing": "has no attribute 'Nothing'",
                "tests.unit.sdk.worker_cases:NOT_A_FACTORY": "is 3; a factory is something to call",
            }.items():
                with pytest.raises(PluginError, match=said):
                    worker.make_from(path)
            with pytest.raises(
                ComponentFault, match=r"RuntimeError: no such arm \(worker_cases.py:\d+ in make_wrongly"
            ):
                worker.make_from("tests.unit.sdk.worker_cases:make_wrongly")
