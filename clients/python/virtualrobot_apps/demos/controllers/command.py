"""`virtualrobot demo controllers`: starts a kernel and three emulated controllers, and programs that work there."""

from __future__ import annotations

from importlib.util import find_spec

import click
from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.own_kernel import in_kernel

NEEDS = {"rtde_control": "ur_rtde", "abb_robot_client": "abb-robot-client", "uvicorn": "'virtualrobot[console]'"}
"""Modules that the programs need, and what brings them."""


@click.command()
@click.option("--headless", is_flag=True, help="Open no viewer.")
@target_options
def controllers(target: Target, headless: bool) -> None:
    """Watch programs for real controllers work one cell, and one robot stop before a box.

    A program with abb-robot-client, a client of a server in RAPID and a program with ur-rtde work at emulated
    controllers, and know of nothing else. Starts a kernel of its own and ends it; with --address the demo replaces the
    world of a kernel that runs already.
    """
    lacking = [brings for module, brings in NEEDS.items() if find_spec(module) is None]
    if lacking:
        raise click.UsageError(f"the programs of this demo need more: pip install {' '.join(lacking)}")
    from virtualrobot_apps.demos.controllers import run

    files = {"--token-file": target.token_file, "--certificate": target.certificate}
    options = [word for name, file in files.items() if file is not None for word in (name, str(file))]
    with in_kernel(target, headless, 1.0) as client:
        run.main(client, options, headless)
