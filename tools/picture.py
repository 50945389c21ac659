"""Writes pictures of the docs, taken by the kernel: the demo at work, what is drawn over a world, and a collision.

Usage: python tools/picture.py docs/pictures
"""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path

import click
import numpy as np
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.view.pictures import Picture
from virtualrobot_apps.demos.bins import cell
from virtualrobot_apps.demos.bins.run import CLOSED, above, drop_pose, feed, seen, take
from virtualrobot_apps.demos.palletizing import palletize
from virtualrobot_apps.demos.twin import run
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles import room, ugv
from virtualrobot_apps.vehicles.waypoints import CONTROLLERS, Waypoints

SIZE = 1280, 800


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--box", default=11, show_default=True, help="The demo when the iiwa carries this box to its pallet.")
@click.option("--speed", default=3.0, show_default=True, help="Of the work before, against the wall clock.")
def main(folder: Path, box: int, speed: float) -> None:
    """Write cell.png, the demo when the iiwa carries a box over its pallet, and five other pictures to FOLDER."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        _followed(client, kernel.address).save(folder / "twin.png")
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        _collided(client).save(folder / "collision.png")
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        _annotated(client).save(folder / "capture.png")
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        _gripped(client).save(folder / "bins.png")
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        _indoors(client).save(folder / "ugv-room.png")
    with (
        KernelProcess(headless=True) as kernel,
        virtualrobot.connect(kernel.address) as watcher,
        virtualrobot.connect(kernel.address) as client,
    ):
        watcher.clock.speed_factor = speed
        threading.Thread(target=_work, args=(client,)).start()
        name = f"iiwa-box-{box}"
        for change in watcher.scene.watch():
            if name in change.poses and change.poses[name][0, 3] > 1.0:
                break
        watcher.clock.set_stepped()  # and nobody steps: the world stands still
        watcher.view.capture(size=SIZE).save(folder / "cell.png")
    for name in ("collision", "capture", "cell", "twin", "bins", "ugv-room"):
        click.echo(f"{folder / name}.png: {(folder / f'{name}.png').stat().st_size // 1024} kB")


def _followed(client: virtualrobot.Client, address: str) -> Picture:
    """Return the demo with emulated controllers when both carry a box, their ghosts behind them."""
    work = threading.Thread(target=run.main, args=(client,), kwargs={"headless": True})
    work.start()
    with virtualrobot.connect(address) as watcher:
        for change in watcher.scene.watch():
            if change.ghosts and {"ur-box-1", "abb-box-1"} <= change.ghosts.keys():
                break
        picture = watcher.view.capture(size=SIZE)
    work.join()
    return picture


def _annotated(client: virtualrobot.Client) -> Picture:
    arm = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
    arm.move_joints([0.4, 0.7, 0.0, -1.2, 0.3, 0.9, 0.0])
    view, pose = client.view, virtualrobot.pose
    client.scene.add_part(
        "box", virtualrobot.box(0.3, 0.25, 0.2, color="#c8872f"), pose=pose(0.55, -0.45, 0.1, yaw=0.3)
    )
    client.scene.add_part("ball", virtualrobot.sphere(0.12, color="#3f8f4f"), pose=pose(-0.35, -0.5, 0.12))
    tip = arm.tcp[:3, 3]
    turn = np.linspace(0.0, 4.0 * np.pi, 120)
    path = tip + np.stack([0.16 * np.cos(turn), 0.16 * np.sin(turn), -0.02 * turn], axis=1)
    view.add_lines(path, color="#2060c0", width=3)
    view.add_frame(pose(-0.6, 0.3, 0.02), length=0.3)
    view.add_label("base", pose(-0.6, 0.3, 0.34))
    view.joint_axes, view.bounding_boxes = ["iiwa"], ["box"]
    view.measurements = {"reach": (("box", [0, 0, 0.1]), ("iiwa.lbr_iiwa_link_7", [0, 0, 0.045]))}
    return view.capture(([1.7, -1.9, 1.35], [0.05, -0.1, 0.42]), size=(1280, 720))


def _gripped(client: virtualrobot.Client) -> Picture:
    """Return the cell of two bins while the arm carries its third box."""
    cell.load(client, "mujoco")
    list(feed(client, 8, np.random.default_rng(1), Pace(0.0)))
    for at in range(3):
        grasp = seen(client)[0]
        if at < 2:
            take(client, grasp, drop_pose(at, grasp), Pace(0.0))
    arm = client.robot(cell.ARM)
    for move in (arm.move_pose, above(grasp.pose)), (arm.move_linear, grasp.pose):
        client.clock.run(move[0](move[1], wait=False))
    client.clock.run(arm.tool().move_to_width(CLOSED, wait=False))
    client.clock.run(arm.move_linear(above(grasp.pose), wait=False))
    return client.view.capture(size=SIZE)


def _indoors(client: virtualrobot.Client) -> Picture:
    """Return a UGV on its way around the table of a furnished room."""
    ugv.build(client, list(room.ROUTE))
    room.furnish(client)
    client.view.grid = False
    client.view.background = "#e8edf2"
    ugv.drive(client, Waypoints(list(room.ROUTE[:2]), CONTROLLERS["PID"]))
    return client.view.capture(size=SIZE)


def _collided(client: virtualrobot.Client) -> Picture:
    client.clock.set_stepped()
    arm = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
    scene, pose = client.scene, virtualrobot.pose
    scene.add_object("table", virtualrobot.box(0.8, 1.5, 0.05, color="#cfc6b8"), pose=pose(0.75, 0.0, 0.175))
    scene.add_part("box", virtualrobot.box(0.2, 0.2, 0.3, color="#c8872f"), pose=pose(0.6, -0.1, 0.351, yaw=0.3))
    scene.add_part("post", virtualrobot.cylinder(0.06, 0.5, color="#3f8f4f"), pose=pose(0.7, 0.65, 0.451))
    client.collisions.set("stop")
    client.view.clearances = {"to the post": ("iiwa", "post")}
    for goal, ticks in ([0.5, 0.9, 0.0, -1.2, 0.0, 1.0, 0.0], 3000), ([-0.9, 0.9, 0.0, -1.2, 0.0, 1.0, 0.0], 1000):
        arm.move_joints(goal, speed_factor=0.05, wait=False)
        client.clock.step(ticks)
    return client.view.capture(([1.85, -0.15, 1.05], [0.45, 0.2, 0.38]), size=(1100, 680))


def _work(client: virtualrobot.Client) -> None:
    with suppress(virtualrobot.VirtualRobotError):  # it is closed when the picture is taken
        palletize.main(client, headless=True)


if __name__ == "__main__":
    main()
