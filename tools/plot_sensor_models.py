"""Writes the pictures of docs/sensor-models.md: what the bundled sensor models say of simple scenes.

Usage: python tools/plot_sensor_models.py docs/pictures
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from virtualrobot_apps.chart import Panel, chart
from virtualrobot_plugins.sensor_models.infrared import Infrared, InfraredSettings
from virtualrobot_plugins.sensor_models.laser import Laser, LaserSettings
from virtualrobot_plugins.sensor_models.ultrasonic import Ultrasonic, UltrasonicSettings
from virtualrobot_sdk.rays import NO_ELEMENT, Readings, SensorModel, TrueHits

Array = NDArray[np.float64]

POINTS, SAMPLES, SEED = 121, 4000, 1
DEGREE = np.pi / 180.0


def said(
    model: SensorModel, distance: Array, incidence: Array | float = 0.0, reflectance: float = 1.0, farthest: float = 1e3
) -> Readings:
    """Return the readings of beams whose k rays hit at these distances (n, k), inf for nothing."""
    hit = np.isfinite(distance)
    angle, part = np.where(hit, incidence, 0.0), np.where(hit, reflectance, 0.0)
    element = np.where(hit, 0, NO_ELEMENT).astype(np.int32)
    return model.apply(TrueHits(distance, angle, part, element, 0.0, farthest), np.random.default_rng(SEED))


def spread(readings: Readings) -> float:
    """Return the standard deviation of the valid readings in meters."""
    return float(readings.distance[readings.valid].std())


def laser_noise() -> str:
    """Return how the noise of a Hokuyo URG-04LX grows with the distance, at right angles and at a slant."""
    distances = np.linspace(0.0, 4.0, POINTS)[1:]
    model = Laser(LaserSettings(deviation_meters=0.005, relative_deviation=0.005))
    slants = (0.0, 60.0, 80.0)
    measured = [[spread(said(model, np.full((SAMPLES, 1), d), slant * DEGREE)) for slant in slants] for d in distances]
    panel = Panel("deviation in mm", [f"at {slant:g}°" for slant in slants], 1e3 * np.array(measured), 220)
    return chart(distances, [panel], along="distance in m")


def laser_range() -> str:
    """Return which part of its echoes a SICK LMS111 finds, by distance, reflectance and slant."""
    distances = np.linspace(0.0, 70.0, POINTS)[1:]
    model = Laser(LaserSettings(detection_range_meters=18.0, detection_reflectance=0.1))
    targets = {"10%": (0.0, 0.1), "90%": (0.0, 0.9), "90% at 60°": (60.0, 0.9)}
    measured = [
        [said(model, np.full((SAMPLES, 1), d), a * DEGREE, r).valid.mean() for a, r in targets.values()]
        for d in distances
    ]
    return chart(distances, [Panel("part found", list(targets), np.array(measured))], along="distance in m")


def laser_edge() -> str:
    """Return what a beam says that passes over the edge of a plate, 2 m away and 30 cm before a wall."""
    places = np.linspace(0.0, 30.0, POINTS)
    spot = LaserSettings(deviation_meters=0.0, divergence_radians=(0.01, 0.01), rays=128, pulse_meters=0.1)
    models = {
        "one echo": Laser(replace(spot, pulse_meters=0.5)),
        "strongest": Laser(spot),
        "first": Laser(replace(spot, echo="first")),
    }
    beam = models["first"].beam()
    across = 1e3 * 2.0 * beam[:, 1] / beam[:, 0]
    distance = np.where(across < places[:, None] - 15.0, 2.0, 2.3)
    behind = np.stack([said(model, distance).distance - 2.0 for model in models.values()], axis=1)
    panel = Panel("behind the plate, in cm", list(models), 100.0 * behind, 180)
    return chart(places, [panel], (5.0, 25.0), along="where the edge is, in mm; the spot is between the dashed lines")


def ultrasonic() -> str:
    """Return what an HC-SR04 says of a wall 1.5 m along its axis that turns."""
    tilts = np.linspace(0.0, 60.0, POINTS)
    models = [
        Ultrasonic(UltrasonicSettings(deviation_meters=0.0, without_echo="zero", roughness=part)) for part in (0.0, 0.3)
    ]
    curves = []
    for model in models:
        beam = model.beam()
        normals = np.stack([np.cos(tilts * DEGREE), np.sin(tilts * DEGREE), np.zeros(POINTS)], axis=1)
        cosine = normals @ beam.T
        distance = 1.5 * normals[:, :1] / np.maximum(cosine, 1e-9)
        curves.append(said(model, distance, np.arccos(np.clip(cosine, 0.0, 1.0)), farthest=4.0).distance)
    across = 1.5 * np.cos(tilts * DEGREE)
    names = ["smooth wall", "30% rough", "across", "on the axis"]
    drawn = np.stack([*curves, across, np.full(POINTS, 1.5)], axis=1)
    return chart(tilts, [Panel("reading in m", names, drawn, 220)], along="tilt of the wall in degrees")


def infrared() -> str:
    """Return voltage, reading and error of Sharp's GP2Y0A21."""
    distances = np.linspace(0.0, 0.8, POINTS)[1:]
    model = Infrared(InfraredSettings(deviation_volts=0.0, without_echo="zero"))
    noisy = Infrared(InfraredSettings())
    volts = model.voltage(distances)
    reading = said(model, distances[:, None], farthest=0.8).distance
    trusted = distances >= 0.1
    error = np.zeros(len(distances))
    error[trusted] = [spread(said(noisy, np.full((SAMPLES, 1), d), farthest=10.0)) for d in distances[trusted]]
    panels = [
        Panel("voltage in V", ["voltage"], volts[:, None]),
        Panel("reading in cm", ["reading", "truth"], 100.0 * np.stack([reading, distances], axis=1)),
        Panel("deviation in cm", ["from 10 cm on"], 100.0 * error[:, None]),
    ]
    return chart(100.0 * distances, panels, (7.0,), along="distance in cm")


PICTURES: dict[str, Callable[[], str]] = {
    "laser-noise": laser_noise,
    "laser-range": laser_range,
    "laser-edge": laser_edge,
    "ultrasonic": ultrasonic,
    "infrared": infrared,
}


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
def main(folder: Path) -> None:
    """Write the pictures to FOLDER: sensor-NAME.svg."""
    for name, picture in PICTURES.items():
        (folder / f"sensor-{name}.svg").write_text(picture(), "utf-8")


if __name__ == "__main__":
    main()
