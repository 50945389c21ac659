"""A person pilots a vehicle under water in a real kernel, by keys of a terminal and by a gamepad."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import threading
from contextlib import suppress

import numpy as np
import pytest
from virtualrobot import Client
from virtualrobot.cli.gamepad import Gamepad
from virtualrobot.cli.gamepad_mapping import read_mapping
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.vehicles import pilot, sail
from virtualrobot_apps.vehicles.vehicle_file import read

from tests.gamepads import virtual_pad
from tests.kernels import KernelProcess
from tests.waiting import repeated, until

KEY_SECONDS = 0.03
"""Time (s) after which a terminal repeats a key that is held."""


def place(client: Client) -> np.ndarray:
    return client.scene.pose(f"{sail.ROBOT}.hull")[:3, 3]


def heading(client: Client) -> float:
    pose = client.scene.pose(f"{sail.ROBOT}.hull")
    return math.atan2(pose[1, 0], pose[0, 0])


def speed(client: Client) -> float:
    return float(np.linalg.norm(client.robot(sail.ROBOT).state.velocities[:6]))


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals that Python can open")
def test_a_vehicle_is_piloted_by_the_keys_of_a_terminal(kernel: KernelProcess, client: Client) -> None:
    """It goes ahead and up and turns while a key is held, and keeps its place against the current without one."""
    import pty

    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "virtualrobot", "demo", "rov", "--address", kernel.address]
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True) as process:
        os.close(theirs)
        said = bytearray()

        def show() -> None:
            with suppress(OSError):  # the terminal of a process that has ended
                while part := os.read(ours, 65536):
                    said.extend(part)

        reader = threading.Thread(target=show, daemon=True)
        reader.start()
        try:
            until(lambda: b"rov at" in said)
            with repeated(lambda: os.write(ours, b"w"), KEY_SECONDS):
                until(lambda: place(client)[0] > 0.5)
            until(lambda: speed(client) < 0.02)
            rested = place(client)
            assert abs(rested[1]) < 0.3, "the current would carry it by 0.25 m/s"
            with repeated(lambda: os.write(ours, b"t"), KEY_SECONDS):
                until(lambda: place(client)[2] > rested[2] + 0.3)
            with repeated(lambda: os.write(ours, b"a"), KEY_SECONDS):
                until(lambda: heading(client) > 0.3)
            until(lambda: speed(client) < 0.02)
            os.write(ours, b"q")
            assert process.wait(60.0) == 0
        finally:
            process.kill()
            reader.join(60.0)
            os.close(ours)
    assert b"rov is at" in said and b"left to the water" in said


def test_a_vehicle_is_piloted_by_a_gamepad(client: Client) -> None:
    vehicle = read(sail.VEHICLE)
    sail.build(client, vehicle, [])
    with virtual_pad() as virtual, Gamepad() as pad:
        held = pilot.held_pad(pad, read_mapping(pilot.MAPPING))

        def at(x: float, y: float) -> bool:
            held.read()
            here = place(client)
            return here[0] > x and here[1] > y

        with pilot.Pilot(client, sail.ROBOT, vehicle, held.wanted) as leading:
            virtual.press("right_shoulder")
            virtual.move(left_y=-1.0)
            until(lambda: at(0.2, -1.0))
            virtual.move(left_y=0.0, left_x=-1.0)
            until(lambda: at(0.0, 0.2))
            assert not leading.error
    with pytest.raises(WrongStateError, match="the mapping has no 'tool'"):
        pilot.held_pad(pad, read_mapping())


def test_what_is_refused_lets_the_thrusters_stand_until_something_is_wanted_anew(client: Client) -> None:
    vehicle = read(sail.VEHICLE)
    sail.build(client, vehicle, [])
    told = [(0.3, 0.0, 0.0, 0.0)]
    with pilot.Pilot(client, sail.ROBOT, vehicle, lambda: told[0]) as leading:
        until(lambda: place(client)[0] > 0.1)
        client.stop()
        until(lambda: leading.error)
        told[0] = (0.0, 0.0, 0.0, 0.0)
        until(lambda: abs(client.robot(sail.ROBOT).state.velocities[6:]).max() < 0.1)  # they lag behind, ever less
        told[0] = (0.3, 0.0, 0.0, 0.0)
        x = place(client)[0]
        until(lambda: place(client)[0] > x + 0.2)
        assert not leading.error


def test_a_vehicle_that_cannot_go_sideways_is_refused(client: Client) -> None:
    client.load_robot("model://remus100", name="fish")
    with pytest.raises(WrongStateError, match="the thrusters of 'fish' cannot move it sideways alone"):
        pilot.Pilot(client, "fish", read("remus100"), lambda: (0.0, 0.0, 0.0, 0.0))
