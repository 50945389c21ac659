"""The worker process: results, refusals and every kind of fault, each with a real process."""

from __future__ import annotations

import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.kinematics import InverseResult, InverseStatus, SerialChain
from virtualrobot_sdk.worker import Worker
from virtualrobot_sdk.worker import frames as wire

from tests.unit.sdk.worker_helpers import CASES, MIB, PATIENCE, call, fault_of, is_gone
from tests.waiting import until


@pytest.fixture
def worker() -> Iterator[Worker]:
    with Worker("arm", memory_limit_bytes=100 * MIB) as it:
        it.make_from(CASES)
        yield it


class TestAnswers:
    def test_a_method_is_called_and_an_attribute_read(self, worker: Worker) -> None:
        assert call(worker, "add", 2, 3.5) == 5.5
        assert call(worker, "greeting") == "hello"

    def test_arrays_and_values_of_the_sdk_travel_both_ways(self, worker: Worker, rng: np.random.Generator) -> None:
        q = rng.normal(size=7)
        np.testing.assert_array_equal(call(worker, "poses", q), np.tile(np.eye(4), (8, 1, 1)) * q.sum())
        answer = call(worker, "solution")
        assert isinstance(answer, InverseResult)
        assert answer.status is InverseStatus.SOLVED
        assert answer.configurations == ("elbow up", "elbow down")
        chain = SerialChain(
            pre=rng.normal(size=(2, 4, 4)),
            axis=rng.normal(size=(2, 3)),
            joint_type=np.ones(2, dtype=np.int8),
            q_index=np.arange(2, dtype=np.int32),
            multiplier=np.ones(2),
            offset=np.zeros(2),
            post=np.eye(4),
            lower=-np.ones(2),
            upper=np.ones(2),
            joint_names=("a", "b"),
        )
        back = call(worker, "echo", chain)
        assert isinstance(back, SerialChain)
        assert back.joint_names == chain.joint_names
        np.testing.assert_array_equal(back.pre, chain.pre)

    def test_an_array_of_50_megabytes_comes_back_whole(self, rng: np.random.Generator) -> None:
        array = rng.integers(0, 255, size=50_000_000, dtype=np.uint8)
        with Worker("large") as worker:
            worker.make_from(CASES)
            back = call(worker, "echo", array)
        assert isinstance(back, np.ndarray)
        assert np.array_equal(back, array)
        assert back.flags.writeable

    def test_calls_of_many_threads_each_get_their_own_answer(self, worker: Worker) -> None:
        with ThreadPoolExecutor(8) as pool:
            answers = list(pool.map(lambda i: call(worker, "echo", i), range(400)))
        assert answers == list(range(400))

    def test_arguments_of_a_factory_reach_it(self) -> None:
        with Worker("arguments") as worker:
            worker.make_from(CASES, 1, "two")
            assert call(worker, "arguments") == (1, "two")

    def test_an_argument_that_cannot_travel_is_the_callers_error_and_harms_nothing(self, worker: Worker) -> None:
        with pytest.raises((pickle.PicklingError, AttributeError, TypeError)):
            call(worker, "echo", lambda: 1)
        assert call(worker, "add", 1, 1) == 2

    def test_nothing_is_imported_but_what_is_asked_for(self) -> None:
        with Worker("lean") as worker:
            worker.make_from("builtins:dict")
            assert worker.call("get", 1, deadline_seconds=PATIENCE) is None
            worker.make_from(CASES)
            loaded = call(worker, "modules")
        assert isinstance(loaded, list)
        assert not {"psutil", "msgspec", "pluggy", "logging", "numba", "grpc", "virtualrobot_kernel"} & set(loaded)

    def test_linear_algebra_of_a_worker_runs_in_one_thread(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
        monkeypatch.setenv("OMP_NUM_THREADS", "3")
        with Worker("blas") as worker:
            worker.make_from(CASES)
            assert call(worker, "environment", "OPENBLAS_NUM_THREADS") == "1"
            assert call(worker, "environment", "OMP_NUM_THREADS") == "3"  # What the user says wins.


class TestRefusals:
    def test_an_argument_error_arrives_as_it_was(self, worker: Worker) -> None:
        with pytest.raises(ArgumentError, match="gain is -1; it must be positive") as raised:
            call(worker, "refuse")
        assert raised.value.metadata == {"gain": "-1"}
        with pytest.raises(ArgumentError, match="no") as raised:
            call(worker, "refuse_oddly")
        assert raised.value.metadata == {"way": "out"}
        assert call(worker, "add", 1, 1) == 2

    def test_files_needed_and_plugin_errors_arrive_as_they_were(self, worker: Worker) -> None:
        with pytest.raises(FilesNeeded) as raised:
            call(worker, "need")
        assert raised.value.names == ("meshes/a.stl", "b.stl")
        with pytest.raises(PluginError, match="write it otherwise"):
            call(worker, "plugin_error")


class TestFaultsThatLeaveTheProcessWell:
    def test_what_raises_is_named_with_the_line_of_its_author(self, worker: Worker) -> None:
        fault = fault_of(worker, "fail")
        assert fault.kind is FaultKind.RAISED
        assert fault.reason.startswith("ValueError: the matrix is singular (worker_cases.py:")
        assert fault.reason.endswith(" in _deeper)")
        assert "in fail" in fault.details and "host.py" not in fault.details
        assert call(worker, "add", 1, 1) == 2

    def test_the_line_is_the_authors_also_when_a_library_raises(self, worker: Worker) -> None:
        assert " in fail_in_numpy)" in fault_of(worker, "fail_in_numpy").reason

    def test_to_exit_is_not_the_components_right(self, worker: Worker) -> None:
        assert fault_of(worker, "leave").reason.startswith("SystemExit: licence missing (worker_cases.py:")
        assert call(worker, "add", 1, 1) == 2

    def test_a_method_that_is_missing_is_named(self, worker: Worker) -> None:
        assert "'Cases' object has no attribute 'jacobian'" in fault_of(worker, "jacobian").reason

    def test_a_result_that_cannot_travel_is_nonsense(self, worker: Worker) -> None:
        fault = fault_of(worker, "unpicklable")
        assert fault.kind is FaultKind.NONSENSE
        assert fault.reason.startswith("unpicklable gave a function that cannot travel")
        assert call(worker, "add", 1, 1) == 2

    def test_a_type_of_the_plugins_is_not_imported_by_the_parent(self, tmp_path: Path, worker: Worker) -> None:
        (tmp_path / "strange_types.py").write_text(
            "class Strange: pass\nclass C:\n    def f(self): return [Strange()]\n", encoding="utf-8"
        )
        sys.path.insert(0, str(tmp_path))
        try:
            with Worker("strange") as other:
                other.make_from("strange_types:C")
                fault = fault_of(other, "f")
                assert "strange_types.Strange" in fault.reason and "NumPy" in fault.reason
        finally:
            sys.path.remove(str(tmp_path))
        assert "strange_types" not in sys.modules
        fault = fault_of(worker, "own_type")
        assert fault.kind is FaultKind.NONSENSE and "worker_cases.Own" in fault.reason
        assert call(worker, "add", 1, 1) == 2

    def test_before_a_component_is_made_there_is_nothing_to_call(self) -> None:
        with Worker("empty") as worker, pytest.raises(PluginError, match="forward was asked for before"):
            call(worker, "forward")


class TestFaultsThatEndTheProcess:
    @pytest.mark.long
    @pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells how long a process waits for a core")
    def test_who_waits_for_a_core_does_not_hang(self, worker: Worker) -> None:
        """Eight others have the same core: 0.3 s of work take 2.7."""
        assert worker.pid
        core = min(os.sched_getaffinity(0))
        os.sched_setaffinity(worker.pid, {core})
        spinning = f"import os\nos.sched_setaffinity(0, {{{core}}})\nwhile True: pass"
        others = [subprocess.Popen([sys.executable, "-c", spinning]) for _ in range(8)]
        try:
            worker.call("work", 0.3, deadline_seconds=1.0)
        finally:
            for other in others:
                other.kill()
                other.wait()

    @pytest.mark.parametrize("method", ["hang", "hang_in_native_code"])
    def test_what_hangs_is_killed_and_says_where_it_was(self, worker: Worker, method: str) -> None:
        pid = worker.pid
        fault = fault_of(worker, method, seconds=0.5)
        assert fault.kind is FaultKind.HUNG
        assert fault.reason == f"{method} gave no answer within 0.5 s"
        assert f"in {method}" in fault.details
        assert is_gone(pid)
        again = fault_of(worker, "add", 1, 1)
        assert (again.kind, again.reason) == (fault.kind, fault.reason)
        assert worker.fault is not None and worker.pid is None

    def test_a_process_that_is_stopped_hangs_also_while_it_is_written_to(self, worker: Worker) -> None:
        assert worker.pid is not None
        os.kill(worker.pid, signal.SIGSTOP)
        assert fault_of(worker, "echo", np.zeros(2_000_000), seconds=0.3).kind is FaultKind.HUNG

    def test_a_segmentation_fault_is_named_with_its_line(self, worker: Worker) -> None:
        fault = fault_of(worker, "crash")
        assert fault.kind is FaultKind.DIED
        assert fault.reason == "its process ended with SIGSEGV in crash"
        assert "worker_cases.py" in fault.details and "in crash" in fault.details
        assert fault_of(worker, "add", 1, 1).reason == fault.reason

    def test_an_end_in_the_middle_is_named_with_its_code_and_last_words(self, worker: Worker) -> None:
        fault = fault_of(worker, "die", 3)
        assert fault.reason == "its process ended with exit code 3 in die"
        assert fault.details == "these are my last words"

    def test_a_signal_is_named(self, worker: Worker) -> None:
        assert fault_of(worker, "kill_itself").reason == "its process ended with SIGKILL in kill_itself"

    def test_a_process_that_dies_between_calls_is_met_by_the_next(self, worker: Worker) -> None:
        pid = worker.pid
        call(worker, "die_later")
        until(lambda: is_gone(pid))
        assert fault_of(worker, "add", 1, 1).reason == "its process ended with SIGSEGV in add"

    def test_memory_that_grows_from_call_to_call_has_an_end(self, worker: Worker) -> None:
        with pytest.raises(ComponentFault) as raised:
            for _ in range(40):
                call(worker, "leak", 20)
                time.sleep(0.05)
        assert raised.value.kind is FaultKind.GREW
        assert raised.value.reason.endswith("it may grow by 100 MiB")
        assert fault_of(worker, "add", 1, 1).kind is FaultKind.GREW

    def test_memory_that_grows_within_a_call_has_an_end(self, worker: Worker) -> None:
        assert fault_of(worker, "leak_and_hang", 200).kind is FaultKind.GREW

    @pytest.mark.long
    def test_memory_that_was_there_when_the_component_was_made_does_not_count(self, worker: Worker) -> None:
        call(worker, "leak", 60)
        worker.make_from(CASES, b"x" * (80 * MIB))
        # Long enough for the guard to look several times: it ends because of the time, not of the memory.
        assert fault_of(worker, "leak_and_hang", 60, seconds=0.5).kind is FaultKind.HUNG

    @pytest.mark.parametrize(
        "what", [b"x" * 40, (1 << 40).to_bytes(8, "little") + bytes(8), (3).to_bytes(8, "little") + bytes(8) + b"abc"]
    )
    def test_what_is_no_answer_is_nonsense(self, worker: Worker, what: bytes) -> None:
        fault = fault_of(worker, "scribble", what)
        assert fault.kind is FaultKind.NONSENSE
        assert "no answer that can be read" in fault.reason
        assert fault_of(worker, "add", 1, 1).reason == fault.reason

    def test_an_answer_to_another_call_is_never_delivered(self, worker: Worker) -> None:
        content = pickle.dumps(("result", 42))
        forged = len(content).to_bytes(8, "little") + (1).to_bytes(8, "little") + content
        fault = fault_of(worker, "scribble", forged)
        assert fault.kind is FaultKind.NONSENSE

    def test_no_process_can_be_started(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(sys, "executable", "/nowhere/python")
        with Worker("nowhere") as worker, pytest.raises(ComponentFault, match="cannot be started") as raised:
            worker.make_from(CASES)
        assert raised.value.kind is FaultKind.DIED


def test_frames_are_read_whole_whatever_pieces_they_come_in(rng: np.random.Generator) -> None:
    for size in (0, 1, 65_519, 65_520, 65_521, 1_000_000):
        content = rng.bytes(size)
        out, into = os.pipe()
        with io.FileIO(out, "rb") as reading, io.FileIO(into, "wb") as writing:
            writer = threading.Thread(target=wire.write_frame, args=(writing, 7, content))
            writer.start()
            assert wire.read_frame(reading) == (7, content)
            writer.join()
