"""The command line: a client like any other. Errors are one line; commands are imported only when they are run."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Sequence
from difflib import get_close_matches

import click

from virtualrobot.cli.applications import find_applications, load, short_help
from virtualrobot.cli.options import Target, target_options

_COMMANDS = {
    "serve": ("virtualrobot.cli.serve", "Start a kernel and keep it running."),
    "replay": ("virtualrobot.cli.serve", "Show what a project folder has recorded, or verify it."),
    "shell": ("virtualrobot.cli.shell", "Take commands one after the other, with completion and history."),
    "load": ("virtualrobot.cli.scene", "Load a model or a scene file."),
    "models": ("virtualrobot.cli.scene", "Show the robots and grippers that the kernel knows by name."),
    "save": ("virtualrobot.cli.scene", "Save the world to a scene file."),
    "export": (
        "virtualrobot.cli.scene",
        "Write a robot as URDF, anything as glTF, or a run that is over as a recording.",
    ),
    "ls": ("virtualrobot.cli.scene", "Draw the scene tree."),
    "add": ("virtualrobot.cli.build", "Add a box, a mesh, a table, a frame, a part, a sensor or a light."),
    "rename": ("virtualrobot.cli.build", "Give a node another name."),
    "describe": ("virtualrobot.cli.describe", "Say what a node is for, tag it, or lock it."),
    "attach": ("virtualrobot.cli.build", "Fix a node to another one."),
    "remove": ("virtualrobot.cli.build", "Take nodes out of the world."),
    "state": ("virtualrobot.cli.state", "Show clock, robots, signals and motions."),
    "move": ("virtualrobot.cli.move", "Move a robot."),
    "plan": ("virtualrobot.cli.plan", "Show what a move would do."),
    "check": ("virtualrobot.cli.plan", "Tell whether a move keeps all limits."),
    "start": ("virtualrobot.cli.start", "Start a plan as it was shown or checked."),
    "proposal": ("virtualrobot.cli.proposal", "Show, make, change, approve or reject proposals of motions."),
    "path": ("virtualrobot.cli.path", "Find a way round what stands in between."),
    "drive": ("virtualrobot.cli.drive", "Drive a craft for some seconds."),
    "teleop": ("virtualrobot.cli.teleop", "Drive a craft by the keys of this terminal, or by a gamepad."),
    "jog": ("virtualrobot.cli.jog", "Move a robot by hand: a joint, or the tool centre point in one direction."),
    "teach": ("virtualrobot.cli.teach", "Save where a robot stands as a target or a posture."),
    "run": ("virtualrobot.cli.program", "Run a program from a file."),
    "tasks": ("virtualrobot.cli.tasks", "Show, stop or answer programs that anybody runs."),
    "stop": ("virtualrobot.cli.move", "Stop all robots, or some."),
    "pause": ("virtualrobot.cli.work", "Slow motions to standstill on their paths."),
    "resume": ("virtualrobot.cli.work", "Let motions go on after a pause."),
    "speed": ("virtualrobot.cli.work", "Show or set the factor by which motions are slowed."),
    "grasp": ("virtualrobot.cli.work", "Fix a part to a robot's tool."),
    "release": ("virtualrobot.cli.work", "Let parts go."),
    "tool": ("virtualrobot.cli.work", "Show a robot's tools, choose one, or move it into a state or to a width."),
    "mount": ("virtualrobot.cli.work", "Mount a tool or a gripper on a robot."),
    "unmount": ("virtualrobot.cli.work", "Take a tool or a gripper off a robot."),
    "lease": ("virtualrobot.cli.work", "Lease robots, so that nobody else moves them."),
    "leases": ("virtualrobot.cli.state", "Show who has leased which robots."),
    "token": ("virtualrobot.cli.token", "Make, show or withdraw tokens with roles."),
    "estop": ("virtualrobot.cli.drivers", "Stop all robots until somebody releases them."),
    "signal": ("virtualrobot.cli.signals", "Show, set, create or wait for signals."),
    "history": ("virtualrobot.cli.history", "Show what was changed and by whom."),
    "undo": ("virtualrobot.cli.history", "Take back the newest change, or one of them."),
    "redo": ("virtualrobot.cli.history", "Do again what was undone."),
    "checkpoint": ("virtualrobot.cli.history", "Keep the world as it is under a name, or go back to it."),
    "clock": ("virtualrobot.cli.work", "Show or set how time runs."),
    "step": ("virtualrobot.cli.state", "Let time go on by some ticks."),
    "plugins": ("virtualrobot.cli.plugins", "Show plugins and their components."),
    "kinematics": ("virtualrobot.cli.plugins", "Show or swap what solves a robot's kinematics."),
    "view": ("virtualrobot.cli.view", "Show or set from where the viewer, pictures and films look."),
    "trace": ("virtualrobot.cli.trace", "Draw the ways that nodes go, and keep them as lines."),
    "capture": ("virtualrobot.cli.pictures", "Take a picture, without a browser."),
    "record": ("virtualrobot.cli.recording", "Record joints, scene, sensors and signals, or a film."),
    "pixel": ("virtualrobot.cli.pictures", "Tell what is under a pixel."),
    "measure": ("virtualrobot.cli.pictures", "Tell how far two points are apart."),
    "collision": ("virtualrobot.cli.collision", "Show what touches, what may, and how far things are apart."),
    "physics": ("virtualrobot.cli.physics", "Show or set what moves parts by forces, and which parts."),
    "rays": ("virtualrobot.cli.rays", "Compare ray casters, or cast a ray."),
    "sensor": ("virtualrobot.cli.sensor", "Show, start, stop, read and watch sensors."),
    "report": ("virtualrobot.cli.report", "Write what a report of a fault needs to a zip archive."),
    "repair": ("virtualrobot.cli.repair", "Keep what can be read of a project folder that is damaged."),
    "grade": ("virtualrobot.cli.serve", "Test components of plugins."),
}

_FIRST_STEPS = """
\b
First steps:
  virtualrobot demo                  two robots palletize; open the printed address in a browser
  virtualrobot serve                 start a kernel; then, in another terminal:
  virtualrobot load arm.urdf --name arm
  virtualrobot ls
  virtualrobot state arm
  virtualrobot move arm --joints 0,0.5,0,-1.2,0,0.8,0

From Python: import virtualrobot; client = virtualrobot.connect()
"""


class _Commands(click.Group):
    """Commands of this library, then those of applications; each is imported when it is run."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names, in the order of use."""
        return [*_COMMANDS, *find_applications(_COMMANDS)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name; None when there is none.

        Raises:
            WrongStateError: when it is one of an application that cannot be imported.
        """
        if cmd_name in _COMMANDS:
            return getattr(importlib.import_module(_COMMANDS[cmd_name][0]), cmd_name)
        entry = find_applications(_COMMANDS).get(cmd_name)
        return None if entry is None else load(entry)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the first word names; raise UsageError, with the nearest one, for none."""
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            near = get_close_matches(args[0], self.list_commands(ctx))
            meant = f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
            ctx.fail(f"there is no command {args[0]!r}{meant}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands of the table, which need no import, and those of applications."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in _COMMANDS.items()])
        with formatter.section("Applications"):
            formatter.write_dl([(name, short_help(entry)) for name, entry in find_applications(_COMMANDS).items()])


def _version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import version

        click.echo(f"virtualrobot {version('virtualrobot')}")
        ctx.exit()


@click.group(
    cls=_Commands,
    invoke_without_command=True,
    epilog=_FIRST_STEPS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@target_options
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_version, help="Show the version.")
@click.pass_context
def cli(ctx: click.Context, target: Target) -> None:
    """VirtualRobot: load robots, move them, see the cell in a browser. Meters, radians, seconds."""
    ctx.obj = target
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 when all went well, 1 for refusals, 2 for wrong usage, 130 for Ctrl-C."""
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str], target: Target | None = None) -> int:
    """Run a command and return its exit code; `target` is the kernel of a shell."""
    debug = "--debug" in arguments or (target is not None and target.debug)
    try:
        code = cli.main(list(arguments), prog_name="virtualrobot", standalone_mode=False, obj=target)
    except click.exceptions.Abort:
        code = 130  # Ctrl-C
    except click.ClickException as error:
        click.echo(_wrong_usage(error), err=True)
        code = error.exit_code
    except (Exception, KeyboardInterrupt) as error:
        if debug:
            raise
        code = _refused(error, "--json" in arguments)
    return code if isinstance(code, int) else 0


def _wrong_usage(error: click.ClickException) -> str:
    """Return in one line what is wrong with an order, and where it is told how it is given."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    text = " ".join(error.format_message().rstrip(".").split())
    if context is None:
        return f"virtualrobot: {text}"
    if isinstance(error, click.NoSuchOption) and error.option_name[1:2] in "0123456789.":
        text = "a number that is negative stands behind --, and so does all that follows, as in '-- -0.1 0 0'"
    elif isinstance(error, click.NoSuchOption) and not error.possibilities:
        options = [name for one in context.command.params for name in one.opts if name.startswith("--")]
        text += f"; there are {', '.join(options)}"
    return f"{context.command_path}: {text} (see {context.command_path} --help)"


def _refused(error: BaseException, as_json: bool) -> int:
    """Print what went wrong in one line and return the exit code."""
    if isinstance(error, KeyboardInterrupt):
        return 130
    from virtualrobot.errors import VirtualRobotError

    if as_json and isinstance(error, VirtualRobotError):
        said = {"reason": error.reason, "message": str(error), "metadata": error.metadata}
        click.echo(json.dumps({"error": said}), err=True)
        return 1
    text = " ".join(str(error).split())
    if isinstance(error, OSError) and error.filename and error.strerror:
        text = f"{error.filename}: {error.strerror}"
    if not isinstance(error, VirtualRobotError | OSError):
        text = f"{type(error).__name__}: {text} (--debug shows where)"
    click.echo(f"virtualrobot: {text}", err=True)
    return 1
