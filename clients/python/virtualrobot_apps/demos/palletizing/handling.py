"""Handling of a box by an arm: from the belt, straight up, over, straight down onto the pallet."""

from __future__ import annotations

from typing import Any

import numpy as np
from virtualrobot import Client, Program, pose

from virtualrobot_apps.demos.palletizing.cell import HOME, Station

RISE = 0.2  # meters above its place that a box comes from


def box_program(
    client: Client, station: Station, reference: str, reference_t_box: np.ndarray, holds: bool = False
) -> Program:
    """Return an arm's program for a box: fetch it from the belt, unless the arm holds it, and put it onto the pallet.

    `reference_t_box` says where in a frame of the program or the world the middle of the box comes to.
    """
    robot, signal, height = client.robot(station.robot), f"box_at_{station.robot}", station.box[2]
    hold, let_go = station.tool_states
    box_t_tcp = pose(z=height / 2 - station.grip_depth, roll=np.pi)  # the tool points down
    belt, home = client.scene.pose("conveyor.belt"), robot.postures[HOME]
    pick = pose(station.pick_x, belt[1, 3], belt[2, 3] + height / 2, yaw=station.belt_yaw) @ box_t_tcp
    rise = station.travel_height - pick[2, 3]
    # Near the same posture each time, so that the elbow does not wander.
    near: dict[str, Any] = {"prefer": {name: home[name] for name in robot.chain_joint_names}}
    way: dict[str, Any] = {"velocity": 0.5, "acceleration": 3.0, **near}
    program = client.program().move(robot.ptp(pose(z=rise) @ pick, **near))
    if not holds:
        program.wait(signal).pick_at(robot, pick, approach=rise, state=hold, **way).set(signal, False)
    goal, pallet = reference_t_box @ box_t_tcp, f"pallet-{station.robot}"
    return program.place_at(robot, goal, reference=reference, approach=RISE, state=let_go, parent=pallet, **way)
