"""Ray clusters: what is lost with a node or a worker, and a cluster of this machine that loses both."""

from __future__ import annotations

import logging
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import grpc
import pytest
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.studies import ray_engine
from virtualrobot_apps.studies.command import _engine
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.ray_engine import Ray
from virtualrobot_apps.studies.running import Progress, open_job, run

from tests.apps.studies import CELLS, FAILED, done, written

SLOW = """
import os, time
from pathlib import Path

def spin(cell):
    Path({alive!r}, str(os.getpid())).touch()
    time.sleep(0.005)
    return {{"y": cell.rng.normal(), "odd": None}}
"""


class RayError(Exception):
    """Something of a cluster that went wrong."""


class RayTaskError(RayError):
    """Error of a task itself."""

    def __init__(self, cause: BaseException) -> None:
        """Keep what it raised."""
        super().__init__(str(cause))
        self.cause = cause


class Broken(grpc.RpcError):
    """End of the connection to a head that is gone, as Ray's client tells it."""

    def details(self) -> str:
        return "Socket closed"


@dataclass(eq=False)
class Reference:
    """Task that was begun, and its block."""

    job: Any
    block: Any


class Imitation:
    """The calls of Ray that the engine makes, done in this process: so each end that a task may have is seen.

    `ends` says for a block's first cell what becomes of its task, once each time; it counts what is under way.
    """

    exceptions = SimpleNamespace(RayError=RayError, RayTaskError=RayTaskError)

    def __init__(self, cores: float, ends: dict[int, list[BaseException]]) -> None:
        """Begin with so many cores."""
        self.cores, self.ends, self.began, self.most, self.under_way = cores, ends, dict[str, object](), 0, 0
        self.work: Callable[..., object] = done

    def is_initialized(self) -> bool:
        return bool(self.began)

    def init(self, **settings: object) -> None:
        if settings["address"] == "nowhere:1":
            raise ConnectionError("nobody there")
        self.began = settings | {"threads": os.environ.get("OPENBLAS_NUM_THREADS")}

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": self.cores, "memory": 1e9}

    def shutdown(self) -> None:
        self.began = {}

    def remote(self, **settings: object) -> Callable[[Callable[..., object]], Any]:
        assert settings == {"num_cpus": 1, "max_retries": 0}

        def task(job: Any, block: Any, in_worker: bool) -> Reference:  # noqa: ANN401
            assert job.folder.is_absolute() and in_worker
            self.under_way += 1
            self.most = max(self.most, self.under_way)
            return Reference(job, block)

        def made(work: Callable[..., object]) -> SimpleNamespace:
            self.work = work
            return SimpleNamespace(remote=task)

        return made

    def wait(self, tasks: list[object], num_returns: int, timeout: float) -> tuple[list[object], list[object]]:
        return tasks[-1:], tasks[:-1]  # the order in which they end is nobody's business

    def get(self, task: Reference) -> object:
        self.under_way -= 1
        if self.ends.get(task.block.first):
            error = self.ends[task.block.first].pop()
            if not isinstance(error, RayTaskError):  # it dies in a cell
                Parts(task.job.folder, task.job.study).trace(task.block.first, task.block.last).touch()
            raise error
        return self.work(task.job, task.block)


@pytest.fixture
def imitated(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Imitation]:
    """Return what puts an imitation in Ray's place."""

    def put(cores: float = 3.0, ends: dict[int, list[BaseException]] | None = None) -> Imitation:
        made = Imitation(cores, ends or {})
        monkeypatch.setitem(sys.modules, "ray", made)
        monkeypatch.setattr(ray_engine, "knock", lambda address: None)
        return made

    return put


def test_blocks_are_done_whatever_becomes_of_their_tasks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, imitated: Callable[..., Imitation]
) -> None:
    """One is lost, and another, halved, kills each worker that has its cell 15; the folder is named from here."""
    study = written(tmp_path / "in")
    _, expected = done(study, tmp_path / "expected")
    died = [RayError(f"the node\n  died {one}") for one in range(9)]
    ray = imitated(ends={84: died[:1], 14: died[1:3], 15: died[3:7], 17: died[7:8]})
    monkeypatch.chdir(tmp_path)
    before = os.environ.get("OPENBLAS_NUM_THREADS")
    engine = Ray()
    assert engine.workers == 3
    assert ray.began["address"] == "local" and ray.began["threads"] == "1"
    assert os.environ.get("OPENBLAS_NUM_THREADS") == before
    progress, parts = done(study, Path("out"), engine)
    assert (progress.done, progress.killed) == (CELLS, 1)
    assert ray.most == 6 and not ray.began
    table, wanted = parts.table(), expected.table()
    assert table.column("y").to_pylist()[16:] == wanted.column("y").to_pylist()[16:]
    row = table.slice(15, 1).to_pylist()[0]
    assert row["status"] == "killed" and "killed its worker 3 times: RayError: the node died" in row["error"]


def test_where_nobody_listens_it_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ray itself would try for minutes."""
    ray = Imitation(3.0, {})
    monkeypatch.setitem(sys.modules, "ray", ray)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        port = listening.getsockname()[1]
        assert Ray(f"127.0.0.1:{port}").workers == 3
    ray.shutdown()
    for address in (f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}"):
        with pytest.raises(WrongStateError, match=f"no Ray cluster answers at {address}: .*refused"):
            Ray(address)
    assert not ray.began


def test_workers_are_as_many_as_are_asked_for_or_there(imitated: Callable[..., Imitation], tmp_path: Path) -> None:
    ray = imitated(cores=8.0)
    engine = Ray("ray://head:10001", 2)
    assert engine.workers == 2 and ray.began == {
        "address": "ray://head:10001",
        "log_to_driver": False,
        "logging_level": logging.WARNING,
        "threads": os.environ.get("OPENBLAS_NUM_THREADS"),
    }
    assert done(written(tmp_path / "in"), tmp_path / "out", engine)[0].failed == FAILED
    assert ray.most == 2
    imitated(cores=2.0)
    assert Ray("head:6379", 5).workers == 2
    with pytest.raises(WrongStateError, match=r"this process is at a Ray cluster already: leave it by `ray.shutdown"):
        Ray()


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (RayTaskError(WrongStateError("this worker has numpy 1.0")), "this worker has numpy 1.0"),
        (
            RayTaskError(OSError(28, "No space left on device")),
            "cannot be written: No space left on device; what is done",
        ),
        (
            ConnectionError("the head does not answer"),
            "the Ray cluster at local has gone: the head does not answer; wh",
        ),
        (Broken(), "the Ray cluster at local has gone: Socket closed; what is done stays"),
    ],
)
def test_what_no_other_try_would_mend_ends_the_run(
    tmp_path: Path, imitated: Callable[..., Imitation], raised: BaseException, said: str
) -> None:
    ray = imitated(ends={84: [raised]})
    with pytest.raises(WrongStateError, match=said):
        done(written(tmp_path / "in"), tmp_path / "out", Ray())
    assert not ray.began


def test_bad_places_are_told(monkeypatch: pytest.MonkeyPatch, imitated: Callable[..., Imitation]) -> None:
    for on in ("rai", "ray://host", "http://host:1", "host"):
        with pytest.raises(click.BadParameter, match="local, ray, ray://HOST:PORT or HOST:PORT belongs here, not"):
            _engine(None, on)
    with pytest.raises(click.BadParameter, match="0 workers are this process"):
        _engine(0, "ray")
    imitated()
    with pytest.raises(WrongStateError, match="no Ray cluster answers at nowhere:1: nobody there"):
        _engine(None, "nowhere:1")
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(WrongStateError, match=r"a Ray cluster needs Ray: pip install 'virtualrobot\[ray\]'"):
        _engine(2, "ray")


@contextmanager
def two_nodes() -> Iterator[Any]:
    """Give a cluster of two nodes of this machine, each with a core."""
    utils = pytest.importorskip("ray.cluster_utils", reason="Ray: pip install 'virtualrobot[ray]'")
    memory = 80 * 2**20
    cluster = utils.Cluster(
        initialize_head=True,
        head_node_args={"num_cpus": 1, "object_store_memory": memory, "include_dashboard": False},
    )
    try:
        cluster.add_node(num_cpus=1, object_store_memory=memory)
        yield cluster
    finally:
        cluster.shutdown()


@pytest.mark.long
@pytest.mark.patient
def test_a_cluster_loses_a_node_and_a_worker_and_comes_to_the_same(tmp_path: Path) -> None:
    """The second node goes when a quarter is done, and any worker when a half is."""
    alive = tmp_path / "alive"
    alive.mkdir()
    study = written(tmp_path / "in", function=SLOW.format(alive=str(alive)))
    _, expected = done(study, tmp_path / "expected")
    for file in alive.iterdir():
        file.unlink()
    lost: list[str] = []
    with two_nodes() as cluster:

        def tell(progress: Progress) -> None:
            if not lost and progress.done >= CELLS // 4:
                lost.append("node")
                cluster.remove_node(cluster.list_all_nodes()[-1], allow_graceful=False)
            elif len(lost) == 1 and progress.done >= CELLS // 2:
                lost.append("worker")
                for worker in sorted(int(file.name) for file in alive.iterdir()):
                    kill(worker)

        progress = run(open_job(study, tmp_path / "out", False), Ray(cluster.address), tell)
    assert lost == ["node", "worker"]
    assert (progress.done, progress.failed, progress.killed) == (CELLS, 0, 0)
    assert Parts(tmp_path / "out", study).digest() == expected.digest()


def kill(process: int) -> None:
    """Kill a process, if it is still there."""
    try:
        os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        pass
