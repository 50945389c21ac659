"""`virtualrobot demo boebot`: a Boe-Bot follows a black line by its camera, and stops for a can that its laser sees.

Once it has stood before the can for a while somebody takes the can away, and it goes on. In the end it tells how far it
was off the line, and how odometry has drifted.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, EncoderReading

from virtualrobot_apps.chart import Panel, chart, plan, stacked
from virtualrobot_apps.vehicles.boebot.cockpit import Cockpit
from virtualrobot_apps.vehicles.boebot.drift import Drift, drift_rows
from virtualrobot_apps.vehicles.boebot.line_follower import (
    SPEED,
    STOP_DISTANCE,
    LineFollower,
    find_line,
    library,
)
from virtualrobot_apps.vehicles.boebot.track import Track
from virtualrobot_apps.vehicles.boebot.worlds import ROBOT

Floats = NDArray[np.float64]

WORLD = Path(__file__).parent / "line.yaml"
SENSORS = ("camera", "laser", "encoders")
PERIOD = 0.1
"""Time between two pictures (s)."""
PATIENCE = 2.0
"""Simulation time (s) for which it stands before the can until somebody takes it away."""
LONGEST = 120.0
"""Simulation time (s) after which a run is given up."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a run, n instants of it.

    times: (n,) simulation time since the start (s). poses: (n, 3) true x, y (m) and heading (rad). off: (n,) how far
    the middle of the axle is left of the line (m). told: (n, 3) x, y, heading as odometry tells them by the encoders,
    in the robot's frame. twists: (n, 2) what was told (m/s, rad/s). clear: (n,) least distance of the laser (m), inf
    for none. ways: (n,) way along the line (m). drift: (3,) by name, how far each odometry was off in the end. ticks:
    ticks in all. end: `lap`, `lost` or `time`.
    """

    times: Floats
    poses: Floats
    off: Floats
    told: Floats
    twists: Floats
    clear: Floats
    ways: Floats
    drift: Mapping[str, Floats]
    ticks: int
    end: str

    @property
    def stood(self) -> Floats:
        """Return the instants at which it stood for an obstacle (s)."""
        return self.times[(self.twists == 0.0).all(axis=1) & (self.clear < STOP_DISTANCE)]


def main(client: Client, plot: Path | None = None, pace: float = 0.0) -> Record:
    """Replace the world by a line, follow it once round, print the numbers, and return the record."""
    library()
    track = Track.of()
    client.scene.load_scene(WORLD)
    client.view.set_camera(position=(0.5, -1.4, 1.9), target=(0.5, 0.4, 0.0))
    begun = time.monotonic()
    print(f"Boe-Bot on a line of {track.length:.2f} m, {SPEED:g} m/s, {1.0 / PERIOD:g} pictures a second", flush=True)
    record = follow(client, track, pace)
    end = "done" if record.end == "lap" else record.end
    rms, most = 1e3 * float(np.sqrt(np.mean(record.off**2))), 1e3 * float(np.abs(record.off).max())
    print(f"{'lap':24} {end} in {record.times[-1]:.1f} s, {record.ticks} ticks")
    print(f"{'off the line':24} {rms:.1f} mm rms, {most:.1f} mm at most")
    stood = record.stood
    if len(stood):
        nearest = float(record.clear[np.isin(record.times, stood)].min())
        print(f"{'before the can':24} stood {stood[-1] - stood[0] + PERIOD:.1f} s, the laser told {nearest:.2f} m")
    factor = float(record.times[-1]) / (time.monotonic() - begun)
    print()
    for row in [*document_rows(factor), *drift_rows(record.drift)]:
        print(row)
    if plot is not None:
        plot.write_text(picture(record, track), "utf-8")
        print(f"picture in {plot}", flush=True)
    return record


def follow(
    client: Client, track: Track, pace: float = 0.0, longest: float = LONGEST, until: float | None = None
) -> Record:
    """Follow the line of the world around the robot, once round, to a way `until` (m), or for `longest` (s).

    The clock is stepped, and stands afterwards. A node `can` is taken away once the robot has stood for PATIENCE.
    """
    end = track.length - 0.01 if until is None else until
    follower, rows, waited, result = LineFollower(), [], 0.0, "time"
    counted: list[EncoderReading] = []
    true: list[EncoderReading] = []
    with Cockpit(client, pace, SENSORS) as cockpit:
        drift = Drift(client.robot(ROBOT), cockpit.encoders())
        pose = cockpit.pose
        way = track.nearest(np.array(pose[:2]), 0.0, track.length)[0]
        while cockpit.now < longest:
            pose = cockpit.pose
            way, off = track.nearest(np.array(pose[:2]), max(0.0, way - 0.05), way + 0.1)
            seen = cockpit.picture()
            assert seen.color is not None
            clear = cockpit.distance("laser")
            twist = follower.twist(find_line(seen.color, float(seen.camera_matrix[0, 0])), clear)
            rows.append((cockpit.now, *pose, off, *twist, clear, way))
            counted.append(cockpit.encoders())
            true.append(cockpit.true_wheels)
            if way >= end or follower.is_lost:
                result = "lost" if follower.is_lost else "lap"
                break
            waited = waited + PERIOD if clear < STOP_DISTANCE else 0.0
            if waited > PATIENCE and "can" in client.scene:
                client.scene.remove("can")
            cockpit.drive(*twist, cockpit.ticks_of(PERIOD), SENSORS)
        told = drift.reckon(counted, true)
        table, ticks, apart = np.array(rows), cockpit.ticks, drift.off()
    return Record(
        times=table[:, 0],
        poses=table[:, 1:4],
        off=table[:, 4],
        told=told,
        twists=table[:, 5:7],
        clear=table[:, 7],
        ways=table[:, 8],
        drift=apart,
        ticks=ticks,
        end=result,
    )


def document_rows(real_time_factor: float) -> list[str]:
    """Return the lines of a table: numbers of the document, or of the program that its appendix names, beside ours."""
    rows = [
        ("", "document", "here"),
        ("picture", "640 x 480", "640 x 480"),
        ("speed", "from 0.02 m/s", f"{SPEED:g} m/s"),
        ("stands for what is nearer than", "0.1 m", f"{STOP_DISTANCE:g} m"),
        ("real-time factor", "0.94", f"{real_time_factor:.2f}"),
    ]
    return [f"{name:32} {document:>14} {here:>14}" for name, document, here in rows]


def picture(record: Record, track: Track) -> str:
    """Return an SVG: ways on the floor, and over time how far it was off, what it was told, and what was ahead."""
    above = plan({"line": track.places, "way": record.poses[:, :2], "odometry": record.told[:, :2]})
    over_time = chart(
        record.times,
        [
            Panel("off the line in mm", ("to the left",), 1e3 * record.off[:, None]),
            Panel("told", ("dm/s", "rad/s"), record.twists * np.array([10.0, 1.0])),
            Panel("ahead in m", ("laser",), np.minimum(record.clear, 1.5)[:, None]),
        ],
    )
    return stacked(above, over_time)
