"""Programs with zones over TCP: no stop at the corner, signals in the zone's middle, and notes about what it became."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import motion_pb2, signal_pb2

from tests.api.asking import joints
from tests.api.moving import SUCCEEDED, linear, motion
from tests.api.reading import matrix, state, step
from tests.api.test_program import dwell, move, put, ready, run, shifted, signals
from tests.kernels import Stubs

SHRUNK, DROPPED = motion_pb2.PLAN_NOTE_KIND_ZONE_SHRUNK, motion_pb2.PLAN_NOTE_KIND_ZONE_DROPPED


def test_a_corner_is_rounded_without_a_stop_and_its_signal_set_in_the_middle(stepped: Stubs) -> None:
    at = ready(stepped)
    signals(stepped, "a")
    down, side = shifted(at, z=-0.1), shifted(at, x=0.1, z=-0.1)
    first, second = move(linear("arm", down), blend_distance_meters=0.03), move(linear("arm", side))
    started = run(stepped, first, put("a"), second)
    assert not started.notes
    positions, set_at = [matrix(state(stepped, "arm").world_t_tcp)[:3, 3]], 0
    while motion(stepped, started.motion.id).phase != SUCCEEDED:
        step(stepped)
        positions.append(matrix(state(stepped, "arm").world_t_tcp)[:3, 3])
        on = stepped.signal.GetSignals(signal_pb2.GetSignalsRequest(names=["a"])).signals[0].value.boolean
        set_at = set_at or (on and len(positions) - 1)
    way = np.array(positions)
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    near = np.linalg.norm(way - down[:3, 3], axis=1)
    assert near[set_at] < 0.03 and np.all(steps[2:-2] > 0.0)
    assert steps[near[1:] < 0.03].min() / 0.004 > 0.02  # m/s: it never stands still there
    outside = way[near > 0.03 + 1e-6]
    off = np.minimum(np.abs(outside - at[:3, 3])[:, :2].max(axis=1), np.abs(outside - side[:3, 3])[:, 1:].max(axis=1))
    assert off.max() < 1e-5
    np.testing.assert_allclose(way[-1], side[:3, 3], atol=1e-5)


def test_what_becomes_of_zones_is_told(stepped: Stubs) -> None:
    at = ready(stepped)
    down, side = shifted(at, z=-0.1), shifted(at, x=0.04, z=-0.1)
    started = run(
        stepped,
        move(linear("arm", down), blend_distance_meters=0.05),
        move(linear("arm", side), blend_percent=20.0),
        dwell(0.1),
        move(joints("arm", lbr_iiwa_joint_7=0.3), blend_distance_meters=0.01),
        move(joints("arm", lbr_iiwa_joint_7=0.6)),
    )
    shrunk, waits, turns = started.notes
    assert (shrunk.kind, shrunk.step, shrunk.robot, shrunk.wanted) == (SHRUNK, 0, "arm", 0.05)
    assert shrunk.kept == pytest.approx(0.02, abs=1e-7)  # half of 40 mm
    assert (waits.kind, waits.step, waits.wanted, waits.kept) == (DROPPED, 1, 20.0, 0.0)
    assert (turns.kind, turns.step) == (DROPPED, 3) and "give percent" in turns.message
