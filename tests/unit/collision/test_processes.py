"""Collision processes: the world arrives as it is, reports and errors come back, and what hangs or dies is ended."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import wait

import numpy as np
import psutil
import pytest
from virtualrobot_kernel.collision import process
from virtualrobot_kernel.collision.configurations import CHECK_BLOCK
from virtualrobot_kernel.collision.process import Job
from virtualrobot_kernel.collision.processes import Processes
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.commands import CreateNodes, SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.collision.jobs import PATH
from tests.unit.collision.worlds import LIBRARY, SHAPES, after, somewhere, with_robots, world
from tests.unit.world.builders import shifted
from tests.waiting import until

pytestmark = pytest.mark.long

LONG = 60.0
"""Seconds within which anything happens on any machine."""


@pytest.fixture(scope="module")
def processes() -> Iterator[Processes]:
    """One process that all tests share; some end it."""
    shared = Processes(ShapeLibrary(LIBRARY.load), count=1)
    yield shared
    shared.close()


def cell() -> Snapshot:
    """Return an arm of meshes and a box in its way."""
    box = NodeSpec("box", Kind.OBJECT, "world", shifted(x=0.4, z=0.6), figures=(Figure(Box((0.3, 0.3, 0.3))),))
    return after(with_robots("iiwa"), CreateNodes((box,)))


def reason_of(job: Job) -> KernelError:
    """Return the error that a job ends with."""
    error = job.exception(LONG)
    assert isinstance(error, KernelError)
    return error


def gone(pid: int) -> bool:
    """Return whether there is no such process."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_a_job_sees_the_world_of_its_snapshot(processes: Processes, rng: np.random.Generator) -> None:
    snapshot, here = cell(), CollisionScene(SHAPES)
    seen = set()
    for _ in range(20):
        snapshot = somewhere(snapshot, rng)
        here.place(snapshot)
        found = processes.submit(f"{PATH}touching", snapshot).result(LONG)
        assert found["pairs"] == [(pair.first, pair.second) for pair in here.collisions(Detail.PAIRS)]
        np.testing.assert_array_equal(found["poses"], snapshot.world_t_node)
        seen.add(found["scene"])
    assert len(seen) == 1, "of one structure a scene is made once"


def test_a_job_sees_what_changed_in_the_structure_and_what_may_touch(processes: Processes) -> None:
    box = Figure(Box((0.2, 0.2, 0.2)))
    snapshot = world(
        CreateNodes(
            (
                NodeSpec("mover", Kind.ROBOT, "world", shifted(), figures=(box,)),
                NodeSpec("near", Kind.OBJECT, "world", shifted(x=0.1), figures=(box,)),
            )
        )
    )
    names = snapshot.structure.uid_by_name
    pair = names["mover"], names["near"]
    assert processes.submit(f"{PATH}touching", snapshot).result(LONG)["pairs"] == [pair]
    allowed = after(snapshot, SetAllowedPairs(allow=(("mover", "near", "on purpose"),)))
    assert processes.submit(f"{PATH}touching", allowed).result(LONG)["pairs"] == []
    grown = after(allowed, CreateNodes((NodeSpec("far", Kind.OBJECT, "world", shifted(x=-0.1), figures=(box,)),)))
    found = processes.submit(f"{PATH}touching", grown).result(LONG)["pairs"]
    assert found == [(names["mover"], grown.structure.uid_by_name["far"])]
    assert processes.submit(f"{PATH}touching", snapshot).result(LONG)["pairs"] == [pair]


def test_a_scene_is_made_anew_for_states_of_tools_and_paddings_that_differ_only(processes: Processes) -> None:
    snapshot = after(with_robots("iiwa"), CreateNodes((NodeSpec("box", Kind.OBJECT, "world", shifted(x=0.5, z=0.9)),)))
    padded = after(snapshot, SetCollisionSettings(paddings=(("iiwa.lbr_iiwa_link_3", 0.5),)))
    seen = [processes.submit(f"{PATH}touching", one).result(LONG) for one in (snapshot, padded, snapshot, snapshot)]
    assert [bool(one["pairs"]) for one in seen] == [False, True, False, False]
    assert seen[2]["scene"] == seen[3]["scene"]


def test_a_block_of_configurations_agrees_with_checks_one_by_one(
    processes: Processes, rng: np.random.Generator
) -> None:
    snapshot, here = cell(), CollisionScene(SHAPES)
    index = next(iter(snapshot.structure.robots.values()))
    q_index = np.array(index.q_start, np.int32)
    limits = np.array([(joint.limits.lower, joint.limits.upper) for joint in index.joints])
    rows = rng.uniform(limits[:, 0], limits[:, 1], (200, len(limits)))
    found = processes.submit(CHECK_BLOCK, snapshot, q_index, rows, None).result(LONG)
    free = 0
    for row, pair in zip(rows, found.tolist(), strict=True):
        here.place(standing_at(snapshot, q_index, row))
        touching = [[one.first, one.second] for one in here.collisions(Detail.PAIRS)]
        assert pair in touching if touching else pair == [0, 0]
        free += not touching
    assert 0 < free < len(rows)


def test_reports_come_while_it_runs_and_giving_up_frees_the_process(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "GRACE_SECONDS", LONG)
    heard: list[tuple[int, int]] = []
    job = processes.submit(f"{PATH}counts_until_given_up", cell(), told=heard.append)
    until(lambda: len(heard) > 3)
    job.give_up()
    assert reason_of(job).reason is Reason.WRONG_STATE
    numbers = [number for _, number in heard]
    assert numbers == sorted(set(numbers))
    found = processes.submit(f"{PATH}touching", cell()).result(LONG)
    assert found["pid"] == heard[0][0], "the process goes on with the next job"


def test_cancelling_the_future_gives_up_and_what_waits_in_line_never_begins(processes: Processes) -> None:
    heard: list[object] = []
    runs = processes.submit(f"{PATH}counts_until_given_up", cell(), told=heard.append)
    until(lambda: heard)
    waits = processes.submit(f"{PATH}counts_until_given_up", cell(), told=heard.append)
    assert waits.cancel()
    assert not runs.cancel()
    assert reason_of(runs).reason is Reason.WRONG_STATE
    assert processes.submit(f"{PATH}echoes", cell(), 7).result(LONG) == 7
    assert waits.cancelled()


def test_a_job_that_does_not_hear_that_it_is_given_up_is_ended(processes: Processes) -> None:
    heard: list[int] = []
    job = processes.submit(f"{PATH}never_asks", cell(), told=heard.append)
    until(lambda: heard)
    job.give_up()
    assert reason_of(job).reason is Reason.WRONG_STATE
    assert gone(heard[0])
    assert processes.submit(f"{PATH}echoes", cell(), 7).result(LONG) == 7


@pytest.mark.parametrize("way", ["dies", "killed"])
def test_a_process_that_dies_is_an_error_and_made_anew(processes: Processes, way: str) -> None:
    heard: list[tuple[int, int]] = []
    if way == "dies":
        job = processes.submit(f"{PATH}dies", cell())
    else:
        job = processes.submit(f"{PATH}counts_until_given_up", cell(), told=heard.append)
        until(lambda: heard)
        psutil.Process(heard[0][0]).kill()
    error = reason_of(job)
    assert error.reason is Reason.INTERNAL
    if sys.platform != "win32":
        assert ("SIGABRT" if way == "dies" else "SIGKILL") in str(error)
    assert processes.submit(f"{PATH}echoes", cell(), 7).result(LONG) == 7


def test_a_process_that_dies_while_it_has_nothing_to_do_costs_no_job_anything(processes: Processes) -> None:
    pid = processes.submit(f"{PATH}touching", cell()).result(LONG)["pid"]
    psutil.Process(pid).kill()
    until(lambda: gone(pid))
    assert processes.submit(f"{PATH}touching", cell()).result(LONG)["pid"] != pid


@pytest.mark.parametrize("job", ["never_asks", "holds_the_lock"])
def test_a_job_that_hangs_is_ended(job: str) -> None:
    if job == "holds_the_lock" and sys.platform == "win32":
        pytest.skip("needs the C library's sleep")
    some = Processes(ShapeLibrary(LIBRARY.load), count=1, silent_seconds=4.0)
    try:
        error = reason_of(some.submit(f"{PATH}{job}", world()))
        assert error.reason is Reason.INTERNAL
        assert some.submit(f"{PATH}echoes", world(), 7).result(LONG) == 7
    finally:
        some.close()


def test_errors_come_back_as_they_were_raised(processes: Processes) -> None:
    refused = reason_of(processes.submit(f"{PATH}refuses", cell()))
    assert (refused.reason, str(refused)) == (Reason.LIMIT_EXCEEDED, "7 is too much; 5 is the most")
    assert refused.metadata == {"value": "7"}
    broken = reason_of(processes.submit(f"{PATH}breaks", cell()))
    assert broken.reason is Reason.INTERNAL
    assert "ZeroDivisionError" in str(broken)
    foreign = reason_of(processes.submit(f"{PATH}returns_a_class", cell()))
    assert foreign.reason is Reason.INTERNAL
    assert "State" in str(foreign)
    unknown = reason_of(processes.submit(f"{PATH}nothing_of_this_name", cell()))
    assert "nothing_of_this_name" in str(unknown)
    assert isinstance(processes.submit(f"{PATH}echoes", cell(), threading.Lock()).exception(LONG), TypeError)
    assert processes.submit(f"{PATH}echoes", cell(), 7).result(LONG) == 7


def test_processes_start_when_needed_work_at_once_and_end_when_idle() -> None:
    some = Processes(ShapeLibrary(LIBRARY.load), count=2, idle_seconds=0.3)
    try:
        assert some.pids == []
        heard: list[tuple[int, int]] = []
        jobs = [some.submit(f"{PATH}counts_until_given_up", world(), told=heard.append) for _ in range(2)]
        until(lambda: len({pid for pid, _ in heard}) == 2)
        for job in jobs:
            job.give_up()
        wait(jobs, LONG)
        until(lambda: some.pids == [] and all(gone(pid) for pid, _ in heard))
        assert some.submit(f"{PATH}echoes", world(), 7).result(LONG) == 7
    finally:
        some.close()


def test_closing_ends_all(processes: Processes) -> None:
    some = Processes(ShapeLibrary(LIBRARY.load), count=1)
    heard: list[tuple[int, int]] = []
    runs = some.submit(f"{PATH}counts_until_given_up", world(), told=heard.append)
    waits = some.submit(f"{PATH}counts_until_given_up", world())
    until(lambda: heard)
    some.close()
    assert reason_of(waits).reason is Reason.SHUTTING_DOWN
    assert reason_of(runs).reason is Reason.SHUTTING_DOWN
    until(lambda: gone(heard[0][0]))
    with pytest.raises(KernelError, match="ending"):
        some.submit(f"{PATH}echoes", world(), 7)


@pytest.mark.skipif(sys.platform == "win32", reason="kills by a signal")
def test_a_process_ends_with_the_kernel_that_is_killed() -> None:
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        some = Processes(ShapeLibrary(LIBRARY.load), count=1)
        some.submit(f"{PATH}never_asks", world(), told=lambda pid: os.write(write, pid.to_bytes(8, "little")))
        time.sleep(LONG)
        os._exit(0)
    pid = int.from_bytes(os.read(read, 8), "little")
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    until(lambda: gone(pid))
