"""A program with ur-rtde: it takes parts that an ABB controller has by the signals of that controller."""

import sys
import time

from abb_robot_client.rws import RWS
from rtde_control import RTDEControlInterface
from rtde_receive import RTDEReceiveInterface

feeder, receive, control = RWS(sys.argv[2]), RTDEReceiveInterface(sys.argv[1]), RTDEControlInterface(sys.argv[1])
for part in (1, 2):
    while not feeder.get_digital_io("doPart"):
        time.sleep(0.02)
    control.moveJ([0.0, -1.57, 1.57, -1.57, -1.57, 0.0], 1.5, 2.0)
    pose = receive.getActualTCPPose()
    pose[2] -= 0.05
    control.moveL(pose, 0.5, 1.2)
    feeder.set_digital_io("diTaken", 1)
    while feeder.get_digital_io("doPart"):
        time.sleep(0.02)
    feeder.set_digital_io("diTaken", 0)
    control.moveJ([0.8, -1.57, 1.57, -1.57, -1.57, 0.0], 1.5, 2.0)
    print(f"part {part} is packed", flush=True)
control.stopScript()
control.disconnect()
receive.disconnect()
