"""The picking program in Python: an arm measures a part, picks it up, swings it into a post, and is told of that."""

import math
from pathlib import Path

import virtualrobot
from virtualrobot import pose

CELL = Path(__file__).parent.parent / "cell.yaml"
DOWN, ACROSS = math.pi, math.pi / 2  # the tool points down, its fingers along y


def main() -> None:
    """Do what the programs in the other languages do, and print the same."""
    with virtualrobot.connect() as client:
        print(f"kernel: {client.info.api_version}")
        client.scene.load_scene(CELL)
        arm, eye = client.robot("arm"), client.sensors["eye"]
        print(f"measured: {eye.read().range.distances.item():.2f} m")

        above = arm.ptp(pose(0.5, 0.0, 0.2, roll=DOWN, yaw=ACROSS))
        print(f"planned: {arm.plan(above).duration:.2f} s")
        print(f"moved: {arm.start(above).phase.name}")
        arm.move_linear(pose(0.5, 0.0, 0.08, roll=DOWN, yaw=ACROSS))
        arm.pick("part")
        arm.move_linear(pose(0.5, 0.0, 0.28, roll=DOWN, yaw=ACROSS))
        print(f"picked: the part is at {client.scene.pose('part')[2, 3]:.2f} m")
        print(f"measured: {eye.read().range.distances.item():.2f} m")

        reports = client.collisions.watch()
        next(reports)  # what touches now
        swing = arm.move_joints({"lbr_iiwa_joint_1": math.pi / 2}, wait=False)
        begun = next(event.begun for report in reports for event in report.events if event.begun)
        print(f"touching: {' and '.join(sorted((begun.collision.first, begun.collision.second)))}")
        swing.wait()

        try:
            arm.move_joints({"lbr_iiwa_jiont_4": 0.5})
        except virtualrobot.UnknownNameError as error:
            print(f"refused: {error.reason}, nearest is {error.metadata['nearest']}")


if __name__ == "__main__":
    main()
