"""An arm scans a cell and makes a map of it, which is compared with the true cell. `virtualrobot map` runs it.

The arm goes to poses around the cell, and reads its sensor at each. A laser's echoes grow an octree; the cones of an
ultrasonic sensor a grid by Bayes' rule. What the sensor sees of its own arm is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import UnreachableError
from virtualrobot.scene.node import Node
from virtualrobot.v1 import scene_pb2

from virtualrobot_apps.demos.mapping.bayes_grid import BayesGrid, Cone
from virtualrobot_apps.demos.mapping.octree_map import Keys, OctreeMap, centers_of
from virtualrobot_apps.demos.mapping.surface_truth import Comparison, compare, seen_from, surface_points
from virtualrobot_apps.demos.viewer import show_viewer

Floats = NDArray[np.float64]

SCENE = Path(__file__).parent / "cell.yaml"
ROBOT = "iiwa"
LOW, HIGH = np.array([0.3, -0.6, -0.1]), np.array([1.2, 0.6, 0.6])
"""The corners of what is mapped (m)."""
TARGET = np.array([0.78, 0.0, 0.1])
"""Point that the sensor looks at from EYES, in the world's frame (m)."""
EYES = np.array(
    [
        [0.35, 0.0, 0.65],
        [0.30, 0.40, 0.55],
        [0.30, -0.40, 0.55],
        [0.60, 0.30, 0.65],
        [0.60, -0.30, 0.65],
        [0.45, 0.55, 0.35],
        [0.45, -0.55, 0.35],
        [0.55, 0.0, 0.60],
    ]
)
SURE = 1.0
"""Log-odds from which on a cell of the Bayes grid counts as occupied (a chance of 0.73)."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Echoes (n, 3) of a sensor and its pose (4, 4) at that time, in meters in the world's frame."""

    points: Floats
    world_t_sensor: Floats


class Laser:
    """Grows an octree."""

    sensor = "laser"
    resolution = 0.04

    def __init__(self, resolution: float) -> None:
        """Begin with nothing known."""
        self.map = OctreeMap(resolution)

    def insert(self, scan: Scan) -> None:
        """Take in a scan."""
        self.map.insert(scan.points, scan.world_t_sensor[:3, 3])

    def voxels(self) -> tuple[Keys, Floats]:
        """Return the known voxels and their log-odds."""
        return self.map.voxels(LOW, HIGH)

    def occupied(self) -> Keys:
        """Return the voxels that count as occupied."""
        keys, odds = self.voxels()
        return keys[odds > 0.0]

    def save(self, path: Path) -> None:
        """Write the octree."""
        self.map.save(path)


class Sonar:
    """Fills a grid by Bayes' rule."""

    sensor = "sonar"
    resolution = 0.05
    cone = Cone(half_angle=0.13, error=0.05)

    def __init__(self, resolution: float) -> None:
        """Begin with nothing known."""
        self.map = BayesGrid(LOW, HIGH, resolution)

    def insert(self, scan: Scan) -> None:
        """Take in the readings of all beams that heard an echo."""
        origin = scan.world_t_sensor[:3, 3]
        away = scan.points - origin
        distances = np.linalg.norm(away, axis=1)
        for direction, distance in zip(away / distances[:, None], distances, strict=True):
            self.map.update(origin, direction, float(distance), self.cone)

    def voxels(self) -> tuple[Keys, Floats]:
        """Return the known cells and their log-odds."""
        return self.map.voxels()

    def occupied(self) -> Keys:
        """Return the cells that count as occupied."""
        keys, odds = self.voxels()
        return keys[odds > SURE]

    def save(self, path: Path) -> None:
        """Refuse: OctoMap's files hold octrees."""
        raise ValueError(f"{path.name} would hold an octree; a grid is saved as .npz")


def main(
    client: Client,
    ultrasonic: bool = False,
    resolution: float = 0.0,
    model: str = "",
    save: Path | None = None,
    headless: bool = False,
) -> Comparison:
    """Build the cell, scan it from all poses, show and save the map, and print how it is.

    Args:
        client: of the kernel whose world is replaced.
        ultrasonic: with the ultrasonic sensor instead of the laser.
        resolution: edge of a voxel in meters; 0: 0.04, ultrasonic 0.05.
        model: another sensor model, with its own default settings.
        save: file of the map: `.bt` or `.ot` (octree), or `.npz` (voxels, log-odds).
        headless: open no browser.
    """
    kind = Sonar if ultrasonic else Laser
    resolution = resolution or kind.resolution
    growing = kind(resolution)
    client.scene.load_scene(SCENE)
    client.view.set_camera(position=(-0.5, -1.6, 1.3), target=(0.65, 0.0, 0.2))
    if model:
        client.sensors[kind.sensor].set_model(model)
    if client.info.viewer_url:
        client.view.show_sensor(kind.sensor, points=False, rays=True)
        client.sensors.start(kind.sensor)  # what is shown are readings at a rate; the map's are asked for
    show_viewer(client, headless)
    truth = surface_points(lambda *rays: cast(client, *rays), LOW, HIGH, 0.5 * resolution)
    visible = np.zeros(len(truth), np.bool_)
    shown: Node | None = None
    print(f"the cell has {len(truth):,} points of surfaces, {1000 * 0.5 * resolution:g} mm apart", flush=True)
    try:
        for number in move(client):
            scan = read(client, kind.sensor)
            growing.insert(scan)
            visible |= could_see(client, kind.sensor, truth, scan.world_t_sensor)
            occupied = growing.occupied()
            shown = show(client, shown, occupied, resolution)
            told = f"scan {number} of {len(EYES)}: {len(scan.points):6,} echoes, {len(occupied):5,} voxels occupied"
            print(told, flush=True)
    finally:
        if save is not None:
            write(growing, resolution, save)
            print(f"saved as {save}", flush=True)
    result = compare(lambda *rays: cast(client, *rays), growing.occupied(), resolution, truth, visible)
    print(f"\noccupied voxels           {result.occupied:6,}")
    print(f"  on a surface            {result.true:6,}  {100 * (1 - result.false_rate):6.2f} %")
    print(f"  on none                 {result.occupied - result.true:6,}  {100 * result.false_rate:6.2f} %")
    print(f"surface voxels in view    {result.visible:6,}")
    print(f"  missed                  {result.missed:6,}  {100 * result.missed_rate:6.2f} %", flush=True)
    return result


def move(client: Client) -> Iterator[int]:
    """Go to one pose after the other and yield how many have been reached; one out of reach is passed over."""
    robot = client.robot(ROBOT)
    for number, eye in enumerate(EYES, start=1):
        for turn in np.radians([0, 90, -90, 180]):
            try:
                solution = robot.solve_inverse(looking(eye, TARGET, turn))
            except UnreachableError:
                continue
            robot.move_joints(solution.by_name())
            yield number
            break


def looking(eye: Floats, target: Floats, turn: float) -> Floats:
    """Return the pose (4, 4) at `eye` whose z points to `target`, turned about z."""
    z = (target - eye) / np.linalg.norm(target - eye)
    side = np.cross([0.0, 0.0, 1.0], z)
    x = side / np.linalg.norm(side)
    y = np.cross(z, x)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x, z])
    pose[:3, 3] = eye
    return pose


def read(client: Client, sensor: str) -> Scan:
    """Return one scan, without the echoes of the arm itself."""
    reading = client.sensors[sensor].read(points=True, elements=True, frame="world")
    said = reading.range
    assert said.points is not None and said.elements is not None
    counts = said.valid & ~is_arm(said.elements, said.element_names)
    return Scan(said.points[counts].astype(np.float64), reading.world_t_sensor)


def cast(client: Client, origins: Floats, directions: Floats, max_range: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return how far rays go until they hit something, and which hit anything but the arm."""
    hits = client.rays.cast(origins, directions, max_range=max_range)
    return hits.distances, ~is_arm(hits.elements, hits.element_names)


def is_arm(elements: NDArray[np.int32], names: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return which elements, places in `names`, are the arm's; -1 is none."""
    own = np.array([name.startswith(f"{ROBOT}.") for name in names] + [False])
    return own[elements]


def could_see(client: Client, sensor: str, points: Floats, world_t_sensor: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 3) are within the sensor's field and range, with nothing before them."""
    read = scene_pb2.GetSceneRequest(names=[sensor], read_mask={"paths": ["range_sensor"]})
    settings = client.services.scene.GetScene(read).nodes[0].range_sensor
    raster = settings.pattern.raster
    local = (points - world_t_sensor[:3, 3]) @ world_t_sensor[:3, :3]
    distance = np.linalg.norm(local, axis=1)
    azimuth, elevation = np.arctan2(local[:, 1], local[:, 0]), np.arcsin(local[:, 2] / distance)
    in_field = 2.0 * np.abs(azimuth) < raster.horizontal_field_radians
    in_field &= 2.0 * np.abs(elevation) < raster.vertical_field_radians
    in_field &= (distance > settings.min_range_meters) & (distance < settings.max_range_meters)
    seen = np.zeros(len(points), np.bool_)
    if in_field.any():
        seen[in_field] = seen_from(lambda *rays: cast(client, *rays), points[in_field], world_t_sensor[:3, 3])
    return seen


def show(client: Client, before: Node | None, occupied: Keys, resolution: float) -> Node | None:
    """Show voxels as boxes, coloured by their height, in place of those before; no sensor sees them."""
    if before is not None:
        before.remove()
    if not len(occupied):
        return None
    places = centers_of(occupied, resolution)
    colors = colors_of(places[:, 2])
    edges = 3 * (0.94 * resolution,)
    boxes = [
        virtualrobot.box(*edges, pose=virtualrobot.pose(*place), color=color, roles=["visual"])
        for place, color in zip(places, colors, strict=True)
    ]
    return client.scene.add_annotation("map", boxes)


def colors_of(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return colours (n, 3) of voxels by their heights (n,) in meters; noise may put some outside of the cell."""
    part = np.clip((heights - LOW[2]) / (HIGH[2] - LOW[2]), 0.0, 1.0)
    return np.stack([part, 0.7 - 0.25 * part, 1.0 - part], axis=1)


def write(growing: Laser | Sonar, resolution: float, path: Path) -> None:
    """Save a map as its ending says."""
    if path.suffix != ".npz":
        growing.save(path)
        return
    keys, odds = growing.voxels()
    np.savez_compressed(path, centers=centers_of(keys, resolution), log_odds=odds, resolution=resolution)
