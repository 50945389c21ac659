"""Programs that know nothing of us: they use ur-rtde against a controller, and print what it told as JSON.

Each runs in a process of its own: the library holds the interpreter's lock while it waits.
"""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

DEADLINE = 120.0
_HEAD = """
import json, sys, time
import rtde_control, rtde_io, rtde_receive

host = sys.argv[1]
receive = rtde_receive.RTDEReceiveInterface(host)
control = rtde_control.RTDEControlInterface(host)

def settled(wanted):
    # readings are those of the controller's last cycle
    for _ in range(5000):
        off = max(abs(a - b) for a, b in zip(receive.getActualQ(), wanted))
        if off < 1e-3 and max(map(abs, receive.getActualQd())) < 1e-3:
            break
        time.sleep(0.002)
    return receive.getActualQ()

said = {}
"""
_TAIL = """
control.stopScript()
print(json.dumps(said))
"""

MOVES = """
start = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
said["start"] = [receive.getActualQ(), receive.getActualTCPPose()]
goal = [0.2, -1.4, 1.4, -1.5, -1.4, 0.1]
said["moveJ"] = [control.moveJ(goal, 1.0, 2.0), settled(goal)]
pose = receive.getActualTCPPose()
pose[2] += 0.05
pose[0] -= 0.03
joints = control.getInverseKinematics(pose)
said["inverse"] = joints
said["moveL"] = [control.moveL(pose, 0.25, 1.2), settled(joints), receive.getActualTCPPose(), pose]
said["servoJ"] = []
joints = receive.getActualQ()
for i in range(200):
    began = control.initPeriod()
    joints[5] += 0.0005
    said["servoJ"].append(control.servoJ(joints, 0.0, 0.0, 0.002, 0.1, 300))
    control.waitPeriod(began)
said["servoJ"] = [all(said["servoJ"]), settled(joints), joints]
said["servoStop"] = control.servoStop()
"""
MORE = """
said["speedJ"] = [control.speedJ([0.0, 0.0, 0.0, 0.0, 0.0, 0.3], 2.0, 0.0)]
for _ in range(5000):
    if receive.getActualQd()[5] > 0.29:
        break
    time.sleep(0.002)
said["speedJ"] += [receive.getActualQd(), control.speedStop()]
before = receive.getActualQ()
away = [one + 1.0 for one in before]
said["stopJ"] = [control.moveJ(away, 0.5, 0.5, True), control.getAsyncOperationProgress()]
while max(receive.getActualQd()) < 0.1:
    time.sleep(0.002)
control.stopJ(3.0)
stopped = receive.getActualQ()
said["stopJ"] += [stopped[0] - before[0], max(map(abs, receive.getActualQd())), control.isSteady()]
said["setTcp"] = [control.setTcp([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]), control.getTCPOffset()]
said["setPayload"] = control.setPayload(1.5, [0.0, 0.0, 0.05])
said["forward"] = [control.getForwardKinematics(), receive.getActualTCPPose()]
outputs = rtde_io.RTDEIOInterface(host)
said["outputs"] = [outputs.setStandardDigitalOut(3, True), outputs.setToolDigitalOut(1, True)]
for _ in range(5000):
    if receive.getActualDigitalOutputBits():
        break
    time.sleep(0.002)
said["outputs"].append(receive.getActualDigitalOutputBits())
said["status"] = [control.getRobotStatus(), control.isProgramRunning(), receive.getSafetyMode()]
control.stopScript()
said["stopScript"] = control.isProgramRunning()
said["reuploadScript"] = [control.reuploadScript()]
while not control.isProgramRunning():
    time.sleep(0.002)
said["reuploadScript"].append(control.moveJ(stopped, 1.0, 1.0))
control.triggerProtectiveStop()
for _ in range(5000):
    if receive.isProtectiveStopped():
        break
    time.sleep(0.002)
said["protective"] = [receive.isProtectiveStopped(), receive.getSafetyMode(), control.isProgramRunning()]
"""
PATHS = """
home = receive.getActualTCPPose()

def beside(x, y, z):
    return [home[0] + x, home[1] + y, home[2] + z, *home[3:]]

path = [[*beside(0.0, 0.0, 0.06), 0.2, 1.0, 0.02], [*beside(0.0, 0.06, 0.06), 0.2, 1.0, 0.0]]
said["moveL"] = [control.moveL(path), receive.getActualTCPPose(), path[-1][:6]]
joints = [[0.1, -1.5, 1.5, -1.5, -1.5, 0.0, 1.0, 2.0, 0.01], [0.0, -1.57, 1.57, -1.57, -1.57, 0.0, 1.0, 2.0, 0.0]]
said["moveJ"] = [control.moveJ(joints), settled(joints[-1][:6])]
before = receive.getActualTCPPose()
said["jog"] = [control.jogStart([0.0, 0.0, 0.05, 0.0, 0.0, 0.0], 0)]
while receive.getActualTCPPose()[2] < before[2] + 0.02:
    time.sleep(0.002)
said["jog"] += [control.jogStop(), [a - b for a, b in zip(receive.getActualTCPPose(), before)]]
said["speedL"] = [control.speedL([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], 2.0, 0.0)]
for _ in range(5000):
    if receive.getActualTCPSpeed()[2] > 0.098:
        break
    time.sleep(0.002)
said["speedL"] += [receive.getActualTCPSpeed(), control.speedStop()]
said["within"] = [control.isJointsWithinSafetyLimits([7.0, 0, 0, 0, 0, 0]), control.isPoseWithinSafetyLimits(home)]
said["forces"] = control.getJointTorques()
said["custom"] = control.sendCustomScriptFunction("mine", "set_flag(3, True)")
"""


def told(program: str, host: str) -> dict[str, Any]:
    """Return what a program prints that runs against the controller at `host`."""
    done = subprocess.run(
        [sys.executable, "-c", _HEAD + program + _TAIL, host], capture_output=True, text=True, timeout=DEADLINE
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])
