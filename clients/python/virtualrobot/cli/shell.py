"""`virtualrobot shell`: commands one after the other, in one process and on one connection."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import ShellComplete

from virtualrobot.cli.options import Session, Target, target_options

if TYPE_CHECKING:
    from prompt_toolkit.completion import CompleteEvent, Completion
    from prompt_toolkit.document import Document
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

_ENDS = ("exit", "quit")


@click.command()
@target_options
def shell(target: Target) -> int:
    """Take commands as they are typed, or from standard input, on one connection.

    Tab completes commands, options and names; the history is kept. 'exit' or Ctrl-D ends it, and gives leased robots
    back. From a file or a pipe the first command that fails ends it.
    """
    if target.session is not None:
        raise click.UsageError("this is a shell already")
    with target.connect() as client:
        session = Session(client)
        inside = replace(target, session=session)
        try:
            return interactive(inside) if sys.stdin.isatty() else batch(inside, sys.stdin)
        finally:
            session.release()


def batch(target: Target, lines: Iterable[str]) -> int:
    """Run lines until one fails; return its exit code, or 0."""
    for number, line in enumerate(lines, 1):
        if line.strip() in _ENDS:
            break
        if code := run_line(line, target):
            click.echo(f"virtualrobot: line {number} failed: {line.strip()}", err=True)
            return code
    return 0


def run_line(line: str, target: Target) -> int:
    """Run the command in a line and return its exit code; 0 for an empty line or a comment."""
    from virtualrobot.cli import run

    try:
        words = split(line)
    except ValueError as error:
        click.echo(f"virtualrobot: {error}: {line.strip()}", err=True)
        return 2
    if words[:1] == ["virtualrobot"]:
        words = words[1:]
    if words == ["help"]:
        words = ["--help"]
    return run(words, target) if words else 0


def split(line: str) -> list[str]:
    """Return the words of a line: quotes keep spaces, # begins a comment, a backslash is a sign like any other."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.escape = True, ""
    return list(lexer)


def interactive(target: Target, source: Input | None = None, output: Output | None = None) -> int:
    """Take commands from a terminal until Ctrl-D, with history and completion."""
    from platformdirs import user_state_path
    from prompt_toolkit import PromptSession
    from prompt_toolkit.history import FileHistory, InMemoryHistory

    folder = user_state_path("virtualrobot")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        history = FileHistory(str(Path(folder) / "shell_history"))
    except OSError:
        history = InMemoryHistory()
    prompt: PromptSession[str] = PromptSession(
        history=history, completer=completer(target), complete_in_thread=True, input=source, output=output
    )
    assert target.session is not None
    info = target.session.client.info
    click.echo(f"VirtualRobot {info.version} at {target.session.client.address}; 'help' lists the commands")
    while True:
        try:
            line = prompt.prompt("> ")
        except KeyboardInterrupt:
            continue
        except EOFError:
            return 0
        if line.strip() in _ENDS:
            return 0
        run_line(line, target)


def completer(target: Target) -> Any:  # noqa: ANN401 prompt_toolkit is imported when it is needed
    """Return what completes a line: commands, options, and names from the kernel."""
    from prompt_toolkit.completion import Completer, Completion, PathCompleter
    from prompt_toolkit.document import Document as Line

    files = PathCompleter(expanduser=True)

    class Names(Completer):
        def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
            words, begun = begun_word(document.text_before_cursor)
            for word, kind in completions(target, words, begun):
                if kind == "file":
                    yield from files.get_completions(Line(begun), complete_event)
                else:
                    quoted = f'"{word}"' if " " in word else word
                    yield Completion(quoted, start_position=-len(begun), display=word)

    return Names()


def begun_word(text: str) -> tuple[list[str], str]:
    """Return the whole words of a line so far, and the word that is begun."""
    try:
        words = split(text)
    except ValueError:  # a quote is open
        before, _, begun = text.rpartition('"')
        return split(before), begun
    return (words, "") if not words or text[-1].isspace() else (words[:-1], words[-1])


def completions(target: Target, words: list[str], begun: str) -> list[tuple[str, str]]:
    """Return how a word may go on after others, each with its sort: plain or file."""
    from virtualrobot.cli import cli

    known = ShellComplete(cli, {"obj": target}, "virtualrobot", "").get_completions(words, begun)
    return [(item.value, item.type) for item in known]
