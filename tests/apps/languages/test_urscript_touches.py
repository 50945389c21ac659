"""Contact of the tool, by the kernel's collision monitor."""

from __future__ import annotations

import time

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.emulators.body import Twin
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script
from virtualrobot_apps.emulators.ur.touches import Touches

from tests.apps.languages.urscript_robot import HOME, Played
from tests.apps.ur_programs import told
from tests.drivers.ur_controllers import ControllerProcess, host
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

_DOWN = """def down():
  textmsg(tool_contact())
  steps = 0
  while steps == 0:
    speedl([0, 0, -0.02, 0, 0, 0], 1, 0.01)
    steps = tool_contact(get_target_tcp_speed())
  end
  textmsg([tool_contact() > 0, tool_contact([0, 0, 1, 0, 0, 0]), tool_contact([1, 0, 0, 0, 0, 0])])
  q = get_actual_joint_positions_history(steps)
  stopl(1)
  movel(q, a=1, v=0.1)
  textmsg("there")
end
"""


_UNTIL_CONTACT = """
said["found"] = control.moveUntilContact([0.0, 0.0, -0.03, 0.0, 0.0, 0.0])
said["pose"], said["runs"] = receive.getActualTCPPose(), control.isProgramRunning()
"""


@pytest.mark.long
@pytest.mark.parametrize("held", [False, True])
def test_a_tool_goes_down_until_it_touches(client: virtualrobot.Client, held: bool) -> None:
    """With a rod it hangs from the ceiling, and goes up to the block: directions are those of its base."""
    client.clock.set_realtime()
    arm = client.load_robot("model://ur5e", name="arm", pose=np.diag([1.0, -1.0, -1.0, 1.0]) if held else None)
    arm.set_positions(HOME)
    (x, y, height), down = arm.tcp[:3, 3], 1.0 if held else -1.0
    if held:
        client.scene.add_part("rod", virtualrobot.box(0.02, 0.02, 0.06), pose=virtualrobot.pose(x, y, height + 0.05))
        client.scene.attach("rod", arm.flange)
    client.scene.add_part("block", virtualrobot.box(0.2, 0.2, 0.1), pose=virtualrobot.pose(x, y, height + down * 0.18))
    client.collisions.set("monitor")
    body = Twin(arm)
    try:
        controller = Controller(body)
        controller.touches = Touches(client, arm, body)
        run_script(controller, _DOWN)

        def ended() -> bool:
            time.sleep(0.001)
            controller.cycle()
            return controller.program is None

        until(ended)
        assert (controller.logged, controller.words) == (["0", "[True, 0, 0]", "there"], [])
        way = down * (arm.tcp[2, 3] - height)
        # The block's top is 13 cm below the flange, and the rod's end 8 cm: 1 cm for the time between two checks.
        assert way == pytest.approx(0.05 if held else 0.13, abs=0.012)
    finally:
        body.close()


@pytest.mark.long
def test_a_program_with_ur_rtde_moves_until_contact(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        client.clock.set_realtime()
        arm = client.load_robot("model://ur5e", name="arm")
        arm.set_positions(HOME)
        x, y, height = arm.tcp[:3, 3]
        client.scene.add_part("block", virtualrobot.box(0.2, 0.2, 0.1), pose=virtualrobot.pose(x, y, height - 0.1))
        client.collisions.set("monitor")
        process = ControllerProcess("arm", "--address", kernel.address, host=host(4))
        try:
            said = told(_UNTIL_CONTACT, process.host)
        finally:
            process.kill()
        assert said["found"] is True and said["runs"] is True
        assert height - said["pose"][2] == pytest.approx(0.05, abs=0.02)


def test_an_arm_without_a_kernel_touches_nothing() -> None:
    (said,) = Played("textmsg(tool_contact())").said
    assert "'tool_contact' needs a robot of a kernel that is watched" in said
