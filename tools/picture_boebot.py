"""Writes the picture of docs/boebot.md: a Boe-Bot before a can on its line, and what its camera shows it of the line.

Usage: python tools/picture_boebot.py docs/pictures
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
import virtualrobot
from PIL import Image, ImageDraw
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.vehicles.boebot.line_follower import find_line
from virtualrobot_apps.vehicles.boebot.track import Track
from virtualrobot_apps.vehicles.boebot.worlds import line_world

WIDTH, HEIGHT, GAP = 453, 340, 8
"""Pixels of each half, and the white between them."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
def main(folder: Path) -> None:
    """Write boebot.png into FOLDER."""
    folder.mkdir(parents=True, exist_ok=True)
    kernel = KernelProcess("--stepped", headless=True)
    with kernel, virtualrobot.connect(kernel.address) as client, tempfile.TemporaryDirectory() as there:
        file = Path(there, "line.yaml")
        file.write_text(line_world(Track.of(), can_way=1.3, start_way=1.1), "utf-8")
        client.scene.load_scene(file)
        client.view.background = "#e8edf2"
        client.view.grid = False
        place = client.scene.pose("boebot.base")[:3, 3]
        camera = (place + np.array([0.16, -0.38, 0.22]), place + np.array([0.05, 0.03, 0.03]), 0.62)
        outside = Image.fromarray(client.view.capture(camera, size=(WIDTH, HEIGHT), format="raw").pixels)
        seen = client.sensors["boebot.camera"].read().camera
    assert seen.color is not None
    line = find_line(seen.color, float(seen.camera_matrix[0, 0]))
    assert line is not None
    inside = Image.fromarray(np.ascontiguousarray(seen.color))
    ImageDraw.Draw(inside).ellipse((line.x - 9, line.y - 9, line.x + 9, line.y + 9), fill=(220, 40, 30))
    both = Image.new("RGB", (2 * WIDTH + GAP, HEIGHT), "white")
    both.paste(outside.convert("RGB"), (0, 0))
    both.paste(inside.resize((WIDTH, HEIGHT)), (WIDTH + GAP, 0))
    output = folder / "boebot.png"
    both.save(output, optimize=True)
    click.echo(f"{output}: {both.width}x{both.height}, {output.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
