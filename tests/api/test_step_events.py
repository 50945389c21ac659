"""MotionService.WatchMotionSteps: all that becomes of steps, each with its tick, none lost, as the motion has it."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import motion_pb2

from tests.api.asking import joints, refusal
from tests.api.moving import CANCELLED, SUCCEEDED, linear, motion
from tests.api.reading import matrix, state, step
from tests.api.test_append import STARVED, append, opened, phase, turn
from tests.api.test_motion import cancel
from tests.api.test_program import dwell, move, put, ready, run, shifted, signals
from tests.kernels import Stubs

BEGUN, ZONE, DONE = (
    motion_pb2.PROGRAM_STEP_EVENT_KIND_BEGUN,
    motion_pb2.PROGRAM_STEP_EVENT_KIND_ZONE_ENTERED,
    motion_pb2.PROGRAM_STEP_EVENT_KIND_DONE,
)
RADIUS = 0.02
Response = motion_pb2.WatchMotionStepsResponse


class Watch:
    """Watch of a motion's steps, and what it has told."""

    def __init__(self, stubs: Stubs, id: str) -> None:
        """Begin to watch."""
        request = motion_pb2.WatchMotionStepsRequest(id=id, max_rate_hertz=1e6)
        self._stream = stubs.motion.WatchMotionSteps(request, timeout=100)
        first = next(self._stream)
        self.first = first
        self.events = [*first.events]

    def whole(self) -> list[motion_pb2.ProgramStepEvent]:
        """Return all events, until the motion's end."""
        for response in self._stream:
            self.events += response.events
            self.last = response
        return self.events


def corners(at: np.ndarray) -> list[np.ndarray]:
    """Return where lines end of which each meets the next one at a right angle."""
    return [shifted(at, x=0.08), shifted(at, x=0.08, z=-0.08), shifted(at, z=-0.08)]


def steps_of(at: np.ndarray) -> list[motion_pb2.ProgramStep]:
    """Return lines with zones at both corners, a signal in the first of them, and a dwell."""
    first, second, third = (linear("arm", pose) for pose in corners(at))
    zone = {"blend_distance_meters": RADIUS}
    return [move(first, **zone), put("a"), move(second, **zone), move(third), dwell(0.02)]


def test_steps_begin_enter_zones_and_are_done_at_their_ticks(stepped: Stubs) -> None:
    at = ready(stepped)
    signals(stepped, "a")
    id = run(stepped, *steps_of(at)).motion.id
    watch = Watch(stepped, id)
    assert [(one.kind, one.step) for one in watch.events] == [(BEGUN, 0)]
    seen: dict[int, int] = {}
    near: dict[int, list[float]] = {0: [], 2: []}
    tick = watch.first.stamp.tick
    while motion(stepped, id).phase not in (SUCCEEDED, CANCELLED):
        step(stepped)
        tick += 1
        seen.setdefault(motion(stepped, id).step, tick)
        tcp = matrix(state(stepped, "arm").world_t_tcp)[:3, 3]
        for number, corner in zip(near, corners(at), strict=False):
            near[number].append(float(np.linalg.norm(tcp - corner[:3, 3])))
    events = watch.whole()
    assert watch.last.motion.phase == SUCCEEDED
    kinds = [(one.step, one.kind) for one in events]
    assert kinds == [
        *((0, BEGUN), (0, ZONE), (0, DONE), (1, BEGUN), (1, DONE), (2, BEGUN), (2, ZONE), (2, DONE)),
        *((3, BEGUN), (3, DONE), (4, BEGUN), (4, DONE)),
    ]
    assert [one.step_path for one in events] == [str(one.step) for one in events]
    ticks = [one.tick for one in events]
    assert ticks == sorted(ticks)
    begun = {one.step: one.tick for one in events if one.kind == BEGUN}
    for number, first in seen.items():
        assert begun[number] == (first if number else begun[0])
    for number, distances in near.items():
        (entered,) = [one.tick for one in events if (one.kind, one.step) == (ZONE, number)]
        within = next(place for place, away in enumerate(distances) if away < RADIUS)
        assert entered - watch.first.stamp.tick - 1 == pytest.approx(within, abs=1)


def test_no_event_is_lost_however_many_ticks_go_by_at_once(stepped: Stubs) -> None:
    at = ready(stepped)
    signals(stepped, "a")
    told = []
    for ticks in (1, 700):
        id = run(stepped, move(joints("arm", lbr_iiwa_joint_1=0.3)), *steps_of(at)).motion.id
        watch = Watch(stepped, id)
        while motion(stepped, id).phase not in (SUCCEEDED, CANCELLED):
            step(stepped, ticks)
        begin = watch.first.stamp.tick
        told.append([(one.kind, one.step, one.tick - begin) for one in watch.whole()])
        back = run(stepped, move(joints("arm", lbr_iiwa_joint_1=0.0))).motion.id
        step(stepped, 1000)
        assert phase(stepped, back) == SUCCEEDED
    assert [one[:2] for one in told[0]] == [one[:2] for one in told[1]]
    assert len(told[0]) == 14


def test_an_open_program_tells_its_steps_as_they_come(stepped: Stubs) -> None:
    ready(stepped)
    id = opened(stepped, turn(0.5))
    watch = Watch(stepped, id)
    step(stepped, 5)
    assert not append(stepped, id, turn(0.9)).notes  # joined: the first one has a zone now
    while phase(stepped, id) != STARVED:
        step(stepped)
    append(stepped, id, turn(0.4), last=True)
    while phase(stepped, id) != SUCCEEDED:
        step(stepped)
    kinds = [(one.step, one.kind) for one in watch.whole()]
    assert kinds == [(0, BEGUN), (0, ZONE), (0, DONE), (1, BEGUN), (1, DONE), (2, BEGUN), (2, DONE)]


def test_what_is_cancelled_is_not_done_and_moves_alone_are_one_step(stepped: Stubs) -> None:
    ready(stepped)
    id = run(stepped, move(joints("arm", lbr_iiwa_joint_1=1.0)), dwell(1.0)).motion.id
    watch = Watch(stepped, id)
    step(stepped, 20)
    cancel(stepped, id)
    step(stepped, 300)
    assert [(one.step, one.kind) for one in watch.whole()] == [(0, BEGUN)]
    assert watch.last.motion.phase == CANCELLED
    late = Watch(stepped, id)
    assert not late.whole() and late.first.motion.phase == CANCELLED
    spec = motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_1=0.2)])
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    alone = stepped.motion.StartMotion(motion_pb2.StartMotionRequest(spec=spec, on_disconnect=leave)).motion.id
    watch = Watch(stepped, alone)
    step(stepped, 1000)
    assert [(one.step, one.kind, one.step_path) for one in watch.whole()] == [(0, BEGUN, ""), (0, DONE, "")]
    unknown = motion_pb2.WatchMotionStepsRequest(id="motion-0")
    assert refusal(lambda: next(stepped.motion.WatchMotionSteps(unknown))).reason == "UNKNOWN_NAME"
