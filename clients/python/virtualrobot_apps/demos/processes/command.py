"""`virtualrobot demo weld`, `paint` and others: a process in a cell, each as files that anybody may take and change."""

from __future__ import annotations

from functools import partial

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.demos.processes import CELLS
from virtualrobot_apps.vehicles.command import HEADLESS, SPEED, pace_of, stepped

DEMOS = {
    "weld": ("pipes", "Watch an arm weld a branch onto a pipe: a saddle, once around."),
    "girth": ("pair", "Watch two arms weld both seams of a mitred pipe at once, while a rotator turns it under them."),
    "paint": ("booth", "Watch an arm paint a hood that is bent both ways, pass beside pass."),
    "dispense": ("gluing", "Watch an arm lay a bead of glue on a lid, once around."),
    "polish": ("polishing", "Watch an arm polish the top of a lid, by a pad on a spring."),
    "cut": ("trimming", "Watch an arm cut an opening into a hood, by laser."),
    "spot": ("spots", "Watch an arm weld twelve spots along the rim of a hood, in a short order."),
    "tandem": ("two_guns", "Watch two arms weld the twelve spots of a hood, two at a time."),
    "measure": (
        "probing",
        "Watch an arm touch ten points of a hood by a probe, which tells how it stands off its model.",
    ),
    "mill": ("flange", "Watch an arm mill the groove of a seal into a flange, by G-code."),
    "drill": ("flange", "Watch an arm drill eight holes into a flange, each in two pecks."),
    "stack": ("store", "Watch an arm palletize four blanks of 12 kg, in two layers."),
    "tend": ("shop", "Watch an arm put blanks into a machine tool with a hood and an axis, and into a rack."),
}
"""Cell of each demo, a scene file, and what is seen; the process is a file with the demo's name."""


def _watch(name: str, target: Target, headless: bool, speed: float | None) -> None:
    from virtualrobot_apps.demos.processes import run

    with stepped(target, None, headless) as client:
        run.main(client, CELLS / f"{DEMOS[name][0]}.yaml", CELLS / f"{name}.yaml", pace_of(speed, headless))


def commands() -> list[click.Command]:
    """Return the command of each demo."""
    made = []
    for name, (_, text) in DEMOS.items():
        told = f"""{text}

        Its cell and its process are files of the package, whose places it says. In steps, as fast as the wall clock,
        without viewer as fast as it can. Starts a kernel of its own and ends it; with --address the cell replaces the
        world of a kernel that runs already. Needs the extra `processes`.
        """
        made.append(click.command(name, help=told)(HEADLESS(SPEED(target_options(partial(_watch, name))))))
    return made
