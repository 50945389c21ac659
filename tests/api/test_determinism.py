"""The same commands at the same ticks give the same world, bit for bit, in another process."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from virtualrobot.v1 import kernel_pb2, motion_pb2, scene_pb2

from tests.api.programs import Program, timeless
from tests.kernels import KernelProcess, StartKernel

COMMANDS = 2000


def ran(kernel: KernelProcess, seed: int) -> list[bytes]:
    stubs = kernel.stubs()
    program = Program(stubs, seed)
    program.run(COMMANDS)
    stubs.scene.Apply(
        scene_pb2.ApplyRequest(
            commands=[
                scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot=r, factor=1.0)) for r in ("", "iiwa")
            ]
        )
    )
    last = [
        stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=1000)),
        stubs.scene.GetScene(scene_pb2.GetSceneRequest()),
        stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()),
    ]
    return [*program.answers, *map(timeless, last)]


@pytest.mark.long
def test_two_kernels_in_two_processes_agree_to_the_last_bit(start_kernel: StartKernel, seed: int) -> None:
    kernels = [start_kernel("--stepped"), start_kernel("--stepped")]
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(ran, kernels, [seed, seed])
    assert len(first) == len(second)
    for place, (a, b) in enumerate(zip(first, second, strict=True)):
        assert a == b, f"answer {place} of {len(first)} differs (seed {seed})"
    refused = sum(answer.startswith(b"StatusCode") for answer in first)
    assert COMMANDS * 0.3 < len(first) - refused, "the program must mostly ask for what can be done"
