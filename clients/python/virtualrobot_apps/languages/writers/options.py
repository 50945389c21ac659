"""Options of the commands that write a program for a controller, and the writing itself."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from virtualrobot_apps.languages.writers.statements import RobotProgram
    from virtualrobot_apps.languages.writers.words import Language

LANGUAGES = {"rapid": ".mod", "urscript": ".script", "krl": ".src", "fanuc": ".ls"}
"""Languages, each a module of this package, and how their files end."""

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


def language_options(*, required: bool) -> Callable[[Decorated], Decorated]:
    """Return what adds the options of a written program to a command: language, robot, output, signs, coupling."""
    options = [
        click.option("--as", "language", required=required, type=click.Choice(sorted(LANGUAGES)), help="The language."),
        click.option(
            "--robot",
            metavar="NAME",
            help="The arm whose program it is [that which the program moves, or the only one].",
        ),
        click.option("-o", "--output", type=click.Path(path_type=Path), metavar="FILE", help="Where to [FILE's name]."),
        click.option("--signs", metavar="1,-1,...", help="Senses of a KUKA's axes against the model's [1,1,1,1,1,1]."),
        click.option(
            "--coupling",
            type=float,
            default=1.0,
            show_default=True,
            help="The part of joint 2 by which a FANUC's joint 3 is less than the model's.",
        ),
    ]

    def add(function: Decorated) -> Decorated:
        for option in reversed(options):
            function = option(function)
        return function

    return add


def wanted(signals: dict[str, str], signs: str | None, coupling: float) -> Language:
    """Return what a writer needs to know of the controller; raises UsageError for signs that are no numbers."""
    from virtualrobot_apps.languages.writers.words import Language

    try:
        senses = tuple(float(one) for one in signs.split(",")) if signs else ()
    except ValueError:
        raise click.UsageError(f"--signs takes numbers, as 1,-1,1,1,1,1, not {signs}") from None
    return Language(signals, senses, coupling)


def write(resolved: RobotProgram, language: str, facts: Language, where: Path) -> None:
    """Write a program to a file, and tell what it says otherwise and how many statements it has."""
    from virtualrobot_apps.languages.writers.statements import every

    text = importlib.import_module(f"virtualrobot_apps.languages.writers.{language}").write(resolved, facts)
    where.write_text(text, encoding="utf-8")
    for note in resolved.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(f"{sum(1 for _ in every(resolved.statements))} statements in {where}")
