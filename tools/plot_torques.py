"""Writes a picture of the torques that the paper's arm needs for its cosine trajectory, as the running kernel has them.

Usage: python tools/plot_torques.py docs/pictures/cosine-torques.svg
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.chart import Panel, chart

SECONDS, SAMPLES = 2.0, 201
TURN = np.radians(60.0)
HEIGHT = 340


def cosine(seconds: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return position, velocity and acceleration, (n,) each, of a joint that turns by TURN from rest to rest."""
    rate = np.pi / SECONDS
    wave = TURN / 2 * np.cos(rate * seconds)
    return TURN / 2 - wave, TURN / 2 * rate * np.sin(rate * seconds), wave * rate**2


def torques() -> tuple[list[str], NDArray[np.float64]]:
    """Return the names of the arm's k joints and their torques (SAMPLES, k) in N m, all joints moving alike."""
    times = np.linspace(0.0, SECONDS, SAMPLES)
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot("model://ar_manipulator", name="arm")
        q, v, a = (np.repeat(column[:, None], len(arm.joint_names), axis=1) for column in cosine(times))
        found = arm.solve_inverse_dynamics(q, v, a)
    return list(found.joint_names), found.efforts


@click.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
def main(output: Path) -> None:
    """Write the picture to OUTPUT, an SVG."""
    names, curves = torques()
    times = np.linspace(0.0, SECONDS, SAMPLES)
    output.write_text(chart(times, [Panel("torque in N m", names, curves, HEIGHT)]), "utf-8")
    for name, curve in zip(names, curves.T, strict=True):
        click.echo(f"{name}: {curve.min():.3f} to {curve.max():.3f} N m")


if __name__ == "__main__":
    main()
