"""Draw docs/pictures/navigation.png: the map that a UGV makes of a furnished floor, its way, and the true walls.

.venv/bin/python tools/plot_navigation.py [SECONDS]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import virtualrobot
from PIL import Image, ImageDraw
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.poses import Floats, between, planar
from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

PICTURE = Path(__file__).parents[1] / "docs" / "pictures" / "navigation.png"
SEED, SCALE = 1, 3
"""The floor, and pixels of a cell."""


def main(seconds: float) -> None:
    """Explore for so long (s of simulation time), draw the map, and print by how much the vehicle was off."""
    boxes, start = floors.floor(SEED), np.array(floors.START)
    ways: list[tuple[Floats, Floats]] = []
    with virtualrobot.connect("local") as client:
        floors.build(client, boxes)
        client.load_robot("model://ugv", name="ugv", base="planar", pose=virtualrobot.pose(*start[:2]))
        vehicle = Vehicle(client, "ugv", *sensors_of(client, "ugv"))

        def watch(pose: Floats) -> None:
            ways.append((planar(client.scene.pose("ugv.base")), pose))

        mapper = journeys.explore(client, vehicle, start, watch=watch, longest=seconds).mapper
    true, thought = (np.array(one) for one in zip(*ways, strict=True))
    off = np.hypot(*between(true, thought)[:, :2].T)
    metres = np.hypot(*np.diff(true[:, :2], axis=0).T).sum()
    print(
        f"{metres:.0f} m, {len(mapper.poses)} scans, {mapper.loops} loops: {1e3 * np.sqrt((off**2).mean()):.0f} mm rms"
    )
    print(f"{1e3 * off.max():.0f} mm at most")
    grid = mapper.grid
    shades = np.where(grid.occupied, 40, np.where(grid.free, 255, 214)).astype(np.uint8)[::-1]
    height, width = shades.shape
    image = Image.fromarray(shades).resize((SCALE * width, SCALE * height), Image.Resampling.NEAREST)
    image = image.convert("RGB")
    draw = ImageDraw.Draw(image)

    def pixels(points: Floats) -> list[tuple[float, float]]:
        at = (points - grid.origin) / grid.resolution * SCALE
        return [(float(x), float(SCALE * height - y)) for x, y in at]

    for box in boxes:
        half = 0.5 * np.array([box.wide, box.deep])
        corners = np.array([box.x, box.y]) + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
        draw.line(pixels(corners), fill="#c2410c", width=1)
    draw.line(pixels(thought[:, :2]), fill="#1f5fa8", width=2)
    image.quantize(32).save(PICTURE)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 240.0)
