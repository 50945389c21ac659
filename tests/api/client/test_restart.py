"""A client whose kernel is killed and started again: what is lost is told once, and everything else goes on."""

from __future__ import annotations

import pytest
import virtualrobot
from virtualrobot import KernelGoneError, LeaseEndedError, UnknownNameError

from tests.api.asking import IIWA, PANDA
from tests.kernels import StartKernel


@pytest.mark.long
def test_a_client_goes_on_with_a_kernel_that_was_started_again(start_kernel: StartKernel) -> None:
    first = start_kernel()
    with virtualrobot.connect(first.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        lease = client.lease("arm")
        motion = arm.move_joints(arm.positions + 0.5, wait=False, speed_factor=0.01)
        assert len(arm.limits) == 7
        first.process.kill()
        for lost in (motion.wait, lambda: arm.positions):
            with pytest.raises(KernelGoneError, match=f"no kernel answers at {first.address}"):
                lost()
        assert "no kernel answers" in lease.wait_for_loss(60.0)
        second = start_kernel("--port", first.address.rpartition(":")[2])
        assert second.address == first.address
        with pytest.raises(UnknownNameError, match="'arm'"):
            _ = arm.positions
        with virtualrobot.connect(second.address) as other:
            assert len(other.load_robot(PANDA, name="arm").positions) == 8
        # The structure's revision is what it was, and yet it is another one.
        assert len(arm.positions) == len(arm.limits) == 8
        with pytest.raises(LeaseEndedError, match="a lease that there is not"):
            arm.move_joints(arm.positions * 0.99)
        lease.release()
        arm.move_joints(arm.positions * 0.99)
        assert next(iter(client.scene.watch()))
