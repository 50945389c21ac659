"""Writes the pictures of what viewers show of sensors: a scan's points, and the map that an arm has made.

Usage: python tools/picture_sensors.py docs/pictures
"""

from __future__ import annotations

from pathlib import Path

import click
import virtualrobot
from screenshot import opened, picture
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.mapping import map_cell

WIDTH, HEIGHT = 1000, 640
LOADING_SECONDS = 8.0
"""When nothing new is seen for so long, a browser without a graphics card has got all meshes."""
POSTURE = [0.0, 0.1, 0.0, -1.5, 0.0, 0.75, 0.0]
"""Of the arm that scans, in radians."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
def main(folder: Path) -> None:
    """Write sensor-view.png and map.png into FOLDER."""
    folder.mkdir(parents=True, exist_ok=True)
    with KernelProcess() as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.speed_factor = 5.0
        map_cell.main(client, headless=True)
        client.view.background = "#e8edf2"
        client.view.set_camera(position=(-0.25, -1.5, 1.15), target=(0.55, 0.0, 0.3), field_of_view=0.75)
        client.view.hide_sensor()
        _take(kernel.viewer_url, folder / "map.png")
        client.scene.node("map").remove()
        client.robot(map_cell.ROBOT).move_joints(POSTURE)
        client.view.show_sensor("laser", points=True)
        _take(kernel.viewer_url, folder / "sensor-view.png")


def _take(url: str, output: Path) -> None:
    with opened(url, WIDTH, HEIGHT) as page:
        seen, before = picture(page), b""
        while seen != before:
            page.wait_for_timeout(1000.0 * LOADING_SECONDS)
            seen, before = picture(page), seen
    output.write_bytes(seen)
    click.echo(f"{output}: {WIDTH}x{HEIGHT}, {output.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
