"""`virtualrobot run`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from virtualrobot.cli.applications import find_applications, load
from virtualrobot.cli.move import follow, show_notes
from virtualrobot.cli.options import GO_ON, Target, target_options
from virtualrobot.cli.plan import limits_only, verdict
from virtualrobot.errors import WrongStateError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.state import Phase

_EXAMPLE = """
\b
Example of a FILE; names are those of MotionSpec in the contract:
  schema_version: 1
  steps:
    - move:
        moves:
          - robot: arm
            point_to_point: {joints: {joint_positions: {joint_1: 0.5}}}
    - wait_signal: {condition: {signal: part, value: {boolean: true}}, timeout_seconds: 5}
"""
LANGUAGES = {
    **dict.fromkeys((".mod", ".modx", ".prg", ".sys", ".sysx"), "rapid"),
    ".rpl": "rapl",
    ".script": "urscript",
}
"""Commands for programs of controllers' own languages, by what the names of their files end with."""


class _Run(click.Command):
    """Command that leaves programs of controllers' own languages to those languages' commands, with all options."""

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        parent: click.Context | None = None,
        **extra: Any,  # noqa: ANN401 as click has it
    ) -> click.Context:
        """Return the context of the command that runs or checks what the words name."""
        language = next((LANGUAGES[end] for one in args if (end := Path(one).suffix.lower()) in LANGUAGES), None)
        if language is None:
            return super().make_context(info_name, args, parent, **extra)
        if language == "urscript" and "--check" not in args:
            raise click.UsageError("a script runs where it is sent to: 'virtualrobot emulate ur'; --check tries it")
        entry = find_applications(()).get(language)
        if entry is None:
            raise WrongStateError(f"the command {language!r} is not installed, which runs such programs")
        words = [one for one in args if one != "--check"]
        verb, trial = ("check", ["--run"]) if len(words) < len(args) else ("run", [])
        return load(entry).make_context(language, [verb, *trial, *words], parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:  # noqa: ANN401 as click has it
        """Run the command that the context is of."""
        return super().invoke(ctx) if ctx.command is self else ctx.command.invoke(ctx)


@click.command(cls=_Run, epilog=_EXAMPLE)
@click.argument("file", type=click.Path(exists=True, dir_okay=False))
@click.option("--preempt", is_flag=True, help="Stop what the robots do and take over.")
@click.option("--no-wait", is_flag=True, help="Return at once; the program goes on.")
@click.option(
    "--check",
    is_flag=True,
    help="Tell whether it keeps all limits and touches nothing, with exit code 0 or 1; nothing moves.",
)
@click.option(
    "--break",
    "breakpoints",
    metavar="STEP",
    multiple=True,
    help="Stand before this step, such as 4 or 4[2].0, and ask; may be given again.",
)
@limits_only
@target_options
def run(
    target: Target,
    file: str,
    preempt: bool,
    no_wait: bool,
    check: bool,
    limits_only: bool,
    breakpoints: tuple[str, ...],
) -> int:
    """Run the program in FILE (YAML) and show how far it is; Ctrl-C stops it on its path.

    All steps are planned before anything moves. What the planner makes other than it was asked to is told. A program in
    RAPID or RAPL-II (.mod, .rpl) goes to 'virtualrobot rapid run' or 'rapl run', with all options; with --check to
    their check --run, in a copy of the world, as a script (.script) does, too.
    """
    if limits_only and not check:
        raise click.UsageError("--limits-only goes with --check")
    with target.connect() as client:
        steps = client.read_program(file)
        if check:
            found = steps.check(collisions=not limits_only)
            if found.first_violation is not None:
                click.echo(f"step {found.first_violation.step_path}: ", nl=False)
            return verdict(file, found, limits_only)
        if client.clock.mode == "stepped" and not no_wait:
            click.echo(f"time stands still: the program goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        motion = steps.start(
            wait=False,
            preempt=True if preempt else None,
            on_disconnect="continue" if no_wait else None,
            breakpoints=breakpoints,
        )
        show_notes(motion)
        if no_wait:
            click.echo(f"started {motion.id}: {motion.planned_duration:.2f} s")
            return 0
        if breakpoints:
            _ask_at_steps(motion)
        follow(motion)
        click.echo(f"{motion.id} is done")
        if motion.search is not None:
            x, y, z = motion.search.world_t_tcp[:3, 3]
            where = f"at {x:z.4f}, {y:z.4f}, {z:z.4f}" if motion.search.found else "nothing"
            click.echo(f"found {where}")
    return 0


def _ask_at_steps(motion: Motion) -> None:
    """Ask how to go on each time a program pauses, until it has ended; Ctrl-C cancels it."""
    try:
        while True:
            state = next(one for one in motion.watch() if one.phase is Phase.PAUSED or one.phase.ended)
            if state.phase.ended:
                return
            asked = f"before step {state.step_path}: Enter goes on, s makes one step"
            answer = click.prompt(asked, default="", show_default=False, prompt_suffix=" ")
            (motion.run_step if answer.strip() == "s" else motion.resume)()
    except (KeyboardInterrupt, click.Abort):
        motion.cancel("interrupted from the keyboard")
        raise
