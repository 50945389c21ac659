"""`virtualrobot start`."""

from __future__ import annotations

import click

from virtualrobot.cli.key_hold import check_terminal, hold_option
from virtualrobot.cli.move import follow_to_its_end, show_notes
from virtualrobot.cli.options import GO_ON, Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot check arm --to home
  virtualrobot start plan-3f9a40c1be27
"""


@click.command(epilog=_EXAMPLES)
@click.argument("plan")
@click.option("--digest", default="", metavar="SHA256", help="Refuse another plan than the one with this digest.")
@hold_option
@click.option("--no-wait", is_flag=True, help="Return at once; the motion goes on.")
@target_options
def start(target: Target, plan: str, digest: str, hold: bool, no_wait: bool) -> None:
    """Start a plan as 'virtualrobot plan' has shown it, or 'virtualrobot check' has looked at it.

    Refused with what has changed where the world is not the one any more that it was made for.
    """
    from virtualrobot.motions.state import PlanReference

    check_terminal(hold, no_wait)
    with target.connect() as client:
        if client.clock.mode == "stepped" and not no_wait:
            click.echo(f"time stands still: the motion goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        on_disconnect = "continue" if no_wait else "stop"
        motion = client.start_plan(PlanReference(plan, digest), wait=False, hold=hold, on_disconnect=on_disconnect)
        show_notes(motion)
        follow_to_its_end(motion, no_wait, hold)
