"""`virtualrobot emulate`: programs that speak to a real robot find its twin."""

from __future__ import annotations

import click

from virtualrobot_apps.emulators.abb.command import abb
from virtualrobot_apps.emulators.egm.command import egm
from virtualrobot_apps.emulators.ur.command import ur


@click.group(short_help="Let programs for a real robot find its twin.")
def emulate() -> None:
    """Emulate a robot's controller: a program that speaks to a real one moves the twin in a kernel, unchanged.

    Without ROBOT it moves an arm that is simulated by the emulator itself, and needs no kernel.
    """


emulate.add_command(abb)
emulate.add_command(egm)
emulate.add_command(ur)
