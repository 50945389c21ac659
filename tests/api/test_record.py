"""ViewService.RecordFilm: pictures at equal steps of simulation time, none left out, however slowly they are drawn."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, kernel_pb2, view_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.api.reading import step
from tests.api.test_scene import remove
from tests.kernels import KernelProcess, Stubs

TICK = 0.004
FRONT = view_pb2.Camera(
    position=geometry_pb2.Vector3(y=-2.0, z=0.6), target=geometry_pb2.Vector3(z=0.6), field_of_view_radians=0.9
)


def request(width: int = 32, rate: float = 0.0, seconds: float = 0.0) -> view_pb2.RecordFilmRequest:
    shot = view_pb2.Shot(camera=FRONT, width=width, height=width, format=view_pb2.IMAGE_FORMAT_RAW)
    return view_pb2.RecordFilmRequest(shot=shot, frames_per_second=rate, duration_seconds=seconds)


def due_ticks(first: int, rate: float, count: int) -> list[int]:
    """Return the first tick at or after each picture's time."""
    return [first + math.ceil(k / rate / TICK - 1e-6) for k in range(count)]


@pytest.mark.parametrize("rate", [25.0, 30.0, 250.0])
def test_steps_are_filmed_at_equal_times(stepped: Stubs, rate: float) -> None:
    load(stepped, IIWA, "arm")
    start(stepped, joints("arm", lbr_iiwa_joint_2=1.0))
    stream = stepped.view.RecordFilm(request(rate=rate, seconds=0.4))
    first = next(stream)
    begin = first.stamp.tick
    count = round(0.4 * rate)
    stepped.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=63))
    for _ in range(60):
        step(stepped)
    frames = [first, *stream]
    assert [frame.frame for frame in frames] == list(range(count))
    assert [frame.stamp.tick for frame in frames] == due_ticks(begin, rate, count)
    times = [frame.stamp.simulation_time_seconds - first.stamp.simulation_time_seconds for frame in frames]
    np.testing.assert_allclose(times, np.arange(count) / rate, atol=TICK if rate == 30.0 else 1e-9)
    assert len({frame.image for frame in frames}) > 0.5 * count, "the arm moves in them"
    assert frames[-1].behind == 0


def test_a_frame_shows_the_world_of_its_time(stepped: Stubs) -> None:
    """What Capture shows at a tick, the film shows too, though it is drawn when the world has gone on."""
    load(stepped, IIWA, "arm")
    start(stepped, joints("arm", lbr_iiwa_joint_2=1.0))
    stream = stepped.view.RecordFilm(request(rate=25.0, seconds=0.2))
    seen = [next(stream)]
    captures = []
    for _ in range(5):
        captures.append(stepped.view.CaptureImage(view_pb2.CaptureImageRequest(shot=request().shot)))
        step(stepped, 10)
    seen += stream
    assert [frame.stamp.tick for frame in seen] == [one.stamp.tick for one in captures]
    assert [frame.image for frame in seen] == [one.image for one in captures]


@pytest.mark.long
def test_in_realtime_no_frame_is_left_out_though_drawing_is_slow(stubs: Stubs) -> None:
    """Pictures of 1.4 million pixels take longer than the 20 ms between them."""
    apply(stubs, create(box("a", z=0.6)))
    frames = []
    behind = 0
    film = request(width=1200, rate=50.0, seconds=0.3)
    film.shot.format = view_pb2.IMAGE_FORMAT_PNG
    for frame in stubs.view.RecordFilm(film):
        frames.append((frame.frame, frame.stamp.tick))
        behind = max(behind, frame.behind)
    assert [number for number, _ in frames] == list(range(15))
    assert [tick for _, tick in frames] == due_ticks(frames[0][1], 50.0, 15)
    assert behind > 0, "it was slower than time"


def test_a_recording_that_nobody_reads_is_bounded_and_keeps_what_waits(stepped: Stubs) -> None:
    stream = stepped.view.RecordFilm(request(rate=250.0))
    first = next(stream)
    stepped.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=10_000))
    stepped.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=2_000))
    for k in range(1, 20):
        frame = next(stream)
        assert (frame.frame, frame.stamp.tick) == (k, first.stamp.tick + k)
        assert frame.behind <= 10_000
    stream.cancel()


READER = """
import sys, time, grpc
from virtualrobot.v1 import view_pb2, view_pb2_grpc
shot = view_pb2.Shot(width=640, height=480, format=view_pb2.IMAGE_FORMAT_RAW)
film = view_pb2.RecordFilmRequest(shot=shot, frames_per_second=50.0)
frames = view_pb2_grpc.ViewServiceStub(grpc.insecure_channel(sys.argv[1])).RecordFilm(film)
next(frames)
print("reads", flush=True)
time.sleep(600.0)
"""
"""Reads one picture, and then no more, so that the next ones do not get through."""


def test_a_reader_that_is_killed_is_no_fault_of_the_kernel(stubs: Stubs, kernel: KernelProcess) -> None:
    before = len(kernel.lines)
    with subprocess.Popen([sys.executable, "-c", READER, kernel.address], stdout=subprocess.PIPE, text=True) as reader:
        assert reader.stdout is not None
        assert reader.stdout.readline() == "reads\n"
        for _ in range(20):  # pictures taken meanwhile fill what lies between kernel and reader
            stubs.view.CaptureImage(view_pb2.CaptureImageRequest(shot=request(width=320).shot))
        reader.kill()
    for _ in range(20):
        stubs.view.CaptureImage(view_pb2.CaptureImageRequest(shot=request(width=320).shot))
    assert not [line for line in kernel.lines[before:] if "ERROR" in line or "Traceback" in line]


def test_a_reader_that_leaves_leaves_nothing_behind(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    """Calls go on as before, and another film begins anew."""
    for _ in range(3):
        gone = stepped_kernel.stubs()
        next(gone.view.RecordFilm(request(width=600, rate=250.0)))
        step(stepped, 500)
        gone.channel.close()
    stream = stepped.view.RecordFilm(request(rate=250.0, seconds=0.02))
    first = next(stream)
    step(stepped, 10)
    assert [frame.stamp.tick for frame in (first, *stream)] == due_ticks(first.stamp.tick, 250.0, 5)


def test_a_film_through_a_camera_ends_when_it_is_removed(stepped: Stubs) -> None:
    from tests.api.test_capture import FORWARD, sensor

    apply(stepped, sensor("eye", FORWARD, width=32, height=32))
    stream = stepped.view.RecordFilm(view_pb2.RecordFilmRequest(shot=view_pb2.Shot(camera_sensor="eye")))
    next(stream)
    apply(stepped, remove("eye"))
    step(stepped, 10)
    refused = refusal(lambda: next(stream))
    assert (refused.reason, "has been removed" in refused.message) == ("UNKNOWN_NAME", True)


def test_impossible_films_are_refused(stepped: Stubs) -> None:
    nan = float("nan")
    for field, bad in (
        ("frames_per_second", request(rate=250.1)),
        ("frames_per_second", request(rate=-1.0)),
        ("frames_per_second", request(rate=nan)),
        ("frames_per_second", request(rate=5e-324)),
        ("frames_per_second", request(rate=1e-310)),
        ("duration_seconds", request(seconds=1.7e308)),
        ("duration_seconds", request(seconds=-1.0)),
        ("duration_seconds", request(seconds=nan)),
        ("shot.width", request(width=5000)),
    ):
        refused = refusal(lambda bad=bad: next(stepped.view.RecordFilm(bad)))
        assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", field)


def test_capturing_goes_on_beside_a_film(stepped: Stubs) -> None:
    stream = stepped.view.RecordFilm(request(width=400, rate=250.0, seconds=0.1))
    next(stream)
    step(stepped, 30)
    tick = stepped.view.CaptureImage(view_pb2.CaptureImageRequest(shot=request().shot)).stamp.tick
    assert tick == step(stepped).stamp.tick - 1, "it shows the world as it is, not as the film has it"
    assert len(list(stream)) == 24
