"""The program of the cell: the belt runs, and the arm goes along with each part as it picks it."""

from __future__ import annotations

import virtualrobot
from virtualrobot import Client, Tracking, pose

PARTS = ("part 1", "part 2")
DOWN = pose(roll=3.141592653589793)
SPEED, LENGTH = 0.03, 1.2


def run(client: Client) -> None:
    """Put all parts into the tray while the belt runs."""
    arm, belt = client.robot("arm"), client.robot("conveyor")
    running = belt.start(belt.joint_jog("belt", SPEED, LENGTH), wait=False)
    for number, part in enumerate(PARTS):
        # Not before the part is within reach.
        client.program().wait_part(part, reference="gate", max_distance=0.1, timeout=60).start()
        pick = client.program().pick_at(arm, pose(z=0.026) @ DOWN, part, reference=part, approach=0.1, state="on")
        pick.start(tracking=Tracking("conveyor.belt", window=0.6, max_velocity=SPEED))
        place = pose(y=0.12 - 0.24 * number, z=0.052) @ DOWN
        client.program().place_at(arm, place, reference="tray", approach=0.1, state="off", parent="tray").start()
        arm.move_to("home")
    running.cancel()


if __name__ == "__main__":
    with virtualrobot.connect() as client:
        run(client)
