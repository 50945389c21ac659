"""Writes a picture of the torques that the paper's arm needs for its cosine trajectory, as the running kernel has them.

Usage: python tools/plot_torques.py docs/pictures/cosine-torques.svg
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.kernel_process import KernelProcess

SECONDS, SAMPLES = 2.0, 201
TURN = np.radians(60.0)
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 760, 420, 64, 120, 24, 48
"""Pixels; the last four are the margins around the curves."""

COLORS = ("#1f5fa8", "#c0392b", "#2e8b57", "#8e5bb0", "#d2841f", "#5d6770")


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


def drawing(names: Sequence[str], curves: NDArray[np.float64]) -> str:
    """Return an SVG of curves (n, k) over SECONDS."""
    low, high = np.floor(curves.min()), np.ceil(curves.max())

    def x(seconds: float) -> float:
        return round(LEFT + (WIDTH - LEFT - RIGHT) * seconds / SECONDS, 1)

    def y(torque: float) -> float:
        return round(TOP + (HEIGHT - TOP - BOTTOM) * (high - torque) / (high - low), 1)

    times = np.linspace(0.0, SECONDS, len(curves))
    box = f'viewBox="0 0 {WIDTH} {HEIGHT}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {box} font-family="sans-serif" font-size="13">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for torque in np.arange(low, high + 1.0):
        parts.append(f'<path d="M{x(0.0)} {y(torque)}H{x(SECONDS)}" stroke="{"#888" if torque == 0.0 else "#ddd"}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y(torque) + 4}" text-anchor="end">{torque:g}</text>')
    for seconds in np.arange(0.0, SECONDS + 0.25, 0.5):
        parts.append(f'<path d="M{x(seconds)} {y(low)}V{y(high)}" stroke="#ddd"/>')
        parts.append(f'<text x="{x(seconds)}" y="{y(low) + 18}" text-anchor="middle">{seconds:g}</text>')
    parts.append(f'<text x="{x(SECONDS / 2)}" y="{HEIGHT - 10}" text-anchor="middle">time in s</text>')
    turned = f'transform="translate(20 {y((low + high) / 2)}) rotate(-90)"'
    parts.append(f'<text {turned} text-anchor="middle">torque in N m</text>')
    for place, (name, curve, color) in enumerate(zip(names, curves.T, COLORS, strict=True)):
        points = " ".join(f"{x(t)},{y(torque)}" for t, torque in zip(times, curve, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2"/>')
        height = TOP + 16 + 20 * place
        parts.append(f'<path d="M{WIDTH - RIGHT + 14} {height}h22" stroke="{color}" stroke-width="2"/>')
        parts.append(f'<text x="{WIDTH - RIGHT + 42}" y="{height + 4}">{name}</text>')
    return "\n".join([*parts, "</svg>\n"])


@click.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
def main(output: Path) -> None:
    """Write the picture to OUTPUT, an SVG."""
    names, curves = torques()
    output.write_text(drawing(names, curves), "utf-8")
    for name, curve in zip(names, curves.T, strict=True):
        click.echo(f"{name}: {curve.min():.3f} to {curve.max():.3f} N m")


if __name__ == "__main__":
    main()
