"""Picture of two runs: distances of links from obstacles and position errors over time, as in figures 18 and 19."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.chart import Panel, chart
from virtualrobot_apps.demos.avoidance.control import RECORDED
from virtualrobot_apps.demos.carry import cell

if TYPE_CHECKING:
    from virtualrobot_apps.demos.carry.run import Run

POINTS = 300
"""Number of samples that the picture shows: more would only make it larger."""


def picture(without: Run, by_law: Run) -> str:
    """Return an SVG over time: the distance of each link from obstacles with and without avoidance, and both errors."""
    times = np.linspace(0.0, min(without.times[-1], by_law.times[-1]), POINTS)
    panels = []
    for link in dict.fromkeys((*by_law.links, *without.links)):
        curves = np.column_stack(
            [
                np.interp(times, one.instants, one.distances[:, one.links.index(link)])
                if link in one.links
                else np.full(POINTS, RECORDED)
                for one in (by_law, without)
            ]
        )
        if np.ptp(curves) > 0.0:
            name = link.removeprefix(f"{cell.ARM}.").removeprefix("lbr_iiwa_")
            panels.append(Panel(f"{name}, m", ("with avoidance", "without"), curves, 75))
    for name, one in zip(("with", "without"), (by_law, without), strict=True):
        errors = np.column_stack([np.interp(times, one.times, 1e3 * column) for column in one.errors.T])
        panels.append(Panel(f"error {name}, mm", [f"{axis} {name}" for axis in "xyz"], errors, 110))
    return chart(times, panels)
