"""Writes the README's picture: the demo in the middle of its work, as the viewer shows it.

Usage: python tools/picture.py docs/pictures/cell.png
"""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path

import click
import virtualrobot
from screenshot import opened, picture
from virtualrobot.apps import demo
from virtualrobot.kernel_process import KernelProcess

WIDTH, HEIGHT = 1280, 800
LOADING_SECONDS = 8.0
"""When nothing new is seen for so long, a browser without a graphics card has got all meshes."""


@click.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--box", default=11, show_default=True, help="Taken when the iiwa carries this box to its pallet.")
@click.option("--speed", default=3.0, show_default=True, help="Of the work before, against the wall clock.")
def main(output: Path, box: int, speed: float) -> None:
    """Run the demo until the iiwa carries a box over its pallet; write what is seen then to OUTPUT, a PNG."""
    output.parent.mkdir(parents=True, exist_ok=True)
    with (
        KernelProcess() as kernel,
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
        with opened(kernel.viewer_url, WIDTH, HEIGHT) as page:
            seen, before = picture(page), b""
            while seen != before:
                page.wait_for_timeout(1000.0 * LOADING_SECONDS)
                seen, before = picture(page), seen
        output.write_bytes(seen)
    click.echo(f"{output}: {WIDTH}x{HEIGHT}, {output.stat().st_size // 1024} kB")


def _work(client: virtualrobot.Client) -> None:
    with suppress(virtualrobot.VirtualRobotError):  # it is closed when the picture is taken
        demo.main(client, headless=True)


if __name__ == "__main__":
    main()
