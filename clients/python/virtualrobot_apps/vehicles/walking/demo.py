"""Machines with legs walk on level or rolling ground by a gait: `virtualrobot demo hexapod`, `quadruped`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot import Client

from virtualrobot_apps.chart import Panel, chart
from virtualrobot_apps.vehicles.floor import FRICTION, NO_PHYSICS
from virtualrobot_apps.vehicles.walking.course import Part
from virtualrobot_apps.vehicles.walking.footholds import Stand
from virtualrobot_apps.vehicles.walking.gaits import HEXAPOD_GAITS, QUADRUPED_GAITS, Gait
from virtualrobot_apps.vehicles.walking.machine import Machine, hexapod, quadruped
from virtualrobot_apps.vehicles.walking.play import Record, Strayed, play, strayed
from virtualrobot_apps.vehicles.walking.terrain import SensedGround, rolling, triangles_of
from virtualrobot_apps.vehicles.walking.walk import plan_walk

GROUNDS = ("level", "rolling")
DOCUMENT = (
    "The document (VirtualRobot, figure 6) tells no number of its walker but four threads, which control the legs; "
    "here one motion of the kernel leads them all."
)
"""Comparison with the document that the walkers are made after."""
CELL = 0.05
"""Distance of two heights of rolling ground (m)."""


@dataclass(frozen=True, slots=True)
class Walker:
    """Way in which a machine of the demo walks.

    gaits: those that it has, by name. stroke: how far a foot goes back, seen from the body, while it is on the ground
    (m). clearance: height of a step (m). rolling: height of rolling ground (m). search: how far from its place a foot
    is set down there (m). sway: how far the body leans in the gaits named (m). legs: their names.
    """

    gaits: Mapping[str, Gait]
    stroke: float
    clearance: float
    rolling: float
    search: float
    sway: Mapping[str, float]
    legs: tuple[str, ...]


SIX = ("left front", "right front", "left middle", "right middle", "left rear", "right rear")
FOUR = ("left front", "right front", "left rear", "right rear")
HEXAPOD = Walker(HEXAPOD_GAITS, 0.06, 0.025, 0.03, 0.015, {}, SIX)
SMALL = Walker(QUADRUPED_GAITS, 0.08, 0.04, 0.03, 0.02, {"crawl": 0.04}, FOUR)
LARGE = Walker(QUADRUPED_GAITS, 0.1, 0.05, 0.04, 0.025, {"crawl": 0.05}, FOUR)
MACHINES = {"hexapod": HEXAPOD, "a1": SMALL, "aliengo": LARGE}


def main(
    client: Client,
    model: str = "hexapod",
    gait_name: str = "tripod",
    ground_name: str = "rolling",
    seed: int = 1,
    plot: Path | None = None,
    pace: float = 0.0,
    slope: float = 0.0,
    engine: str = NO_PHYSICS,
) -> Record:
    """Replace the world by a machine and its ground, walk there, print the numbers, and return what the kernel told.

    `pace` are simulated seconds for each second of the wall clock; 0: as fast as it can be. `slope` (rad) and `engine`
    are those of `build`.
    """
    walker = MACHINES[model]
    gait = walker.gaits[gait_name]
    machine, ground = build(client, model, ground_name, seed, slope, engine)
    walk = plan_walk(gait, stand_of(machine, model, gait_name, ground_name), demo_course(walker, gait), ground)
    by = "" if engine == NO_PHYSICS else f" by {engine}"
    print(
        f"{model}{by}, {gait.name} on {ground_name} ground: duty factor {gait.duty_factor:.3g}, "
        f"cycle {gait.cycle:g} s, {sum(map(len, walk.steps))} steps, {ground.rays} rays",
        flush=True,
    )
    record = play(machine, walk, pace)
    for line in [*numbers(record, walker, gait), *(forces_numbers(strayed(record, walk)) if by else ())]:
        print(line, flush=True)
    print(DOCUMENT, flush=True)
    if plot is not None:
        plot.write_text(picture(record, walker, gait), "utf-8")
        print(f"picture in {plot}", flush=True)
    return record


def build(
    client: Client,
    model: str = "hexapod",
    ground_name: str = "level",
    seed: int = 1,
    slope: float = 0.0,
    engine: str = NO_PHYSICS,
) -> tuple[Machine, SensedGround]:
    """Replace the world by the ground and a machine; return the machine, and the ground as rays find it.

    Level ground rises forward by a `slope` (rad). With an `engine` the machine stands on it by forces, and the clock is
    stepped, so that nothing sinks before it is led. Raises ValueError for a ground that is none of GROUNDS.
    """
    if ground_name not in GROUNDS:
        raise ValueError(f"the ground is {' or '.join(GROUNDS)}, not {ground_name!r}")
    if engine != NO_PHYSICS:
        client.clock.set_stepped()
    client.scene.clear()
    if ground_name == "level":
        tilted = virtualrobot.pose(pitch=-slope) @ virtualrobot.pose(z=-0.05)
        figure = virtualrobot.box(6.0, 6.0, 0.1, color="#b8bcc0", pose=tilted)
    else:
        heights = rolling(np.random.default_rng(seed), cell=CELL, height=MACHINES[model].rolling)
        figure = client.assets.triangles(*triangles_of(heights, CELL), color="#a8a08c")
    client.scene.add_object("ground", figure.with_surface(friction=FRICTION))
    machine = hexapod(client) if model == "hexapod" else quadruped(client, model)
    for leg in machine.legs:
        client.collisions.allowed.add(leg.foot, "ground", "it stands there")
    client.view.set_camera(position=(1.2, -1.2, 0.8), target=(0.3, 0.0, 0.1))
    if engine != NO_PHYSICS:
        machine = machine.under_physics(engine)
    return machine, SensedGround(client, ["ground"], [machine.robot.name])


def stand_of(machine: Machine, model: str = "hexapod", gait_name: str = "tripod", ground_name: str = "level") -> Stand:
    """Return how a machine stands, as its posture `home` has it."""
    walker = MACHINES[model]
    feet, height, center = machine.stance()
    return Stand(
        feet,
        height,
        machine.foot_radius,
        walker.clearance,
        walker.search if ground_name == "rolling" else 0.0,
        walker.sway.get(gait_name, 0.0),
        (float(center[0]), float(center[1])),
    )


def demo_course(walker: Walker, gait: Gait) -> list[Part]:
    """Return the course of the demo: straight on for four cycles, a bow to the left for four, and two sideways."""
    speed = gait.speed(walker.stroke)
    return [
        Part(4.0 * gait.cycle, forward=speed),
        Part(4.0 * gait.cycle, forward=0.7 * speed, turn=1.5 * speed),
        Part(2.0 * gait.cycle, left=0.5 * speed),
    ]


def numbers(record: Record, walker: Walker, gait: Gait) -> list[str]:
    """Return the lines that end the demo."""
    measured = record.speed(gait.cycle, 4.0 * gait.cycle)
    told = gait.speed(walker.stroke)
    way = float(np.linalg.norm(np.diff(record.bodies[:, :2, 3], axis=0), axis=1).sum())
    return [
        f"way               {way:.3f} m in {record.times[-1]:.1f} s",
        f"speed             {1e3 * measured:.2f} mm/s straight on; stroke / (duty factor cycle): {1e3 * told:.2f} mm/s",
        f"slip              {1e3 * record.slips.max():.4f} mm at most, of feet on the ground",
        f"stability margin  {1e3 * record.margins.min():.1f} to {1e3 * record.margins.max():.1f} mm",
    ]


def forces_numbers(off: Strayed) -> list[str]:
    """Return the lines that a demo by forces ends with beside the others."""
    stood = "it did not fall" if off.fell is None else f"it fell after {off.fell:.2f} s"
    tilt = np.degrees(off.tilt)
    return [f"off its plan      {1e3 * off.way:.0f} mm in the end, tilted by {tilt:.1f}° at most; {stood}"]


def picture(record: Record, walker: Walker, gait: Gait) -> str:
    """Return an SVG: which feet are on the ground, the stability margin, and the height of body and feet over time."""
    every, count = slice(None, None, 5), len(walker.legs)
    standing = np.arange(count, 0.0, -1.0) + 0.7 * record.stance[every]
    heights = np.column_stack([record.bodies[every, 2, 3], record.feet[every, 0, 2]])
    return chart(
        record.times[every],
        [
            Panel(f"{gait.name}: on the ground", walker.legs, standing),
            Panel("stability margin in mm", ("margin",), 1e3 * record.margins[every, None]),
            Panel("height in mm", ("body", "left front foot"), 1e3 * heights),
        ],
    )
