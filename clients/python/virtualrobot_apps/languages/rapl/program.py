"""Programs in RAPL-II: numbered lines, one command each, a program a file; read and checked before anything moves."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError, did_you_mean
from virtualrobot_apps.languages.core.source import Source, read_source
from virtualrobot_apps.languages.rapl import builtin
from virtualrobot_apps.languages.rapl.forms import Argument, Reader, Uses
from virtualrobot_apps.languages.rapl.lexer import WordError, words_of
from virtualrobot_apps.languages.rapl.locations import Location, read_locations
from virtualrobot_apps.languages.rapl.table import COMMANDS, REFUSED, Command, refusal

_LINE = re.compile(r"[ \t]*(?:(?P<number>\d+)[ \t]*)?(?P<name>;|!|\+\+|--|[A-Za-z][A-Za-z0-9]*)?")
LARGEST_LINE = 32767
"""Largest number of a line."""

builtin.load()


@dataclass(frozen=True, slots=True)
class Statement:
    """One line: its number, its command with arguments, its text, and the line of the file that has it."""

    number: int
    command: Command
    arguments: list[Argument]
    text: str
    at: int


@dataclass(slots=True)
class Program:
    """One program: its name, its source, its statements, and where each number stands among them."""

    name: str
    source: Source
    statements: list[Statement] = field(default_factory=list)
    places: dict[int, int] = field(default_factory=dict)
    uses: Uses = field(default_factory=Uses)


@dataclass(frozen=True, slots=True)
class Loaded:
    """Programs that were read and checked together, by name; the first one is begun with."""

    programs: dict[str, Program]
    locations: dict[str, Location]

    @property
    def first(self) -> str:
        """Name of the program that is begun with."""
        return next(iter(self.programs))

    def signals(self, kind: str) -> list[int]:
        """Return the numbers of the inputs or outputs that are named by a number."""
        found = (int(word.text) for one in self.programs.values() for of, word in one.uses.signals if of == kind)
        return sorted(set(found))

    def first_use(self, *names: str) -> str:
        """Return the place, as `file:line`, of the first statement with one of these commands; empty where none is."""
        for program in self.programs.values():
            for one in program.statements:
                if one.command.name in names:
                    return f"{program.source.file}:{program.source.line(one.at)}"
        return ""


def load(sources: Iterable[Source], locations: Source | None = None) -> Loaded:
    """Return the programs of sources, each named after its file; raises ProgramError with all that is wrong in them."""
    diagnostics = Diagnostics()
    known = read_locations(locations, diagnostics) if locations is not None else {}
    programs: dict[str, Program] = {}
    for source in sources:
        program = _read(source, diagnostics)
        if program.name in programs:
            diagnostics.add(source, 0, f"there are two programs {program.name!r}; a program is called as its file is")
        programs[program.name] = program
    _check(programs, known, diagnostics)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    return Loaded(programs, known)


def load_files(files: Iterable[Path], locations: Path | None = None) -> Loaded:
    """Return the programs of files; raises ProgramError, or MissingFileError."""
    return load(map(read_source, files), None if locations is None else read_source(locations))


def _read(source: Source, diagnostics: Diagnostics) -> Program:
    program = Program(Path(source.file).stem.upper(), source)
    at, last = 0, -1
    for text in source.text.split("\n"):
        found = _LINE.match(text)
        assert found is not None
        if text.strip():
            number = int(found["number"] or 0)
            if found["number"] is None:
                diagnostics.add(source, at, "a line begins with its number, as 10 MOVE A")
            elif not last < number <= LARGEST_LINE:
                said = f"the number {number} must be above that of the line before, {last}"
                diagnostics.add(source, at, said if number <= last else f"a line has a number up to {LARGEST_LINE}")
            else:
                last = number
                _statement(program, number, text, found, at, diagnostics)
        at += len(text) + 1
    if not program.statements and not len(diagnostics):
        diagnostics.add(source, 0, "there is no line in this program")
    return program


def _statement(
    program: Program, number: int, text: str, found: re.Match[str], at: int, diagnostics: Diagnostics
) -> None:
    """Add the statement of a line, or what is wrong in it."""
    name = (found["name"] or "").upper()
    row = COMMANDS.get(name)
    if row is None:
        place = at + (found.start("name") if name else len(text))
        if reason := refusal(name):
            diagnostics.add(program.source, place, f"{name} can't be used here: {reason}")
        elif not name:
            diagnostics.add(program.source, place, "a command is expected after the number of the line")
        else:
            refused = [one for names in REFUSED.values() for one in names]
            hint = did_you_mean(name, [*COMMANDS, *refused])
            diagnostics.add(program.source, place, f"there is no command {name!r}{hint}")
        program.places[number] = len(program.statements)
        return
    rest = text[found.end() :]
    try:
        if row.form == "message":
            arguments = [Argument("message", rest.strip().strip("'"))]
        else:
            begin = at + found.end()
            end = begin + len(rest.rstrip())
            arguments = Reader(words_of(rest, begin), end, program.uses, row.signals).arguments(row.elements)
    except WordError as error:
        wanted = f"; it is {row.name} {row.form}" if row.form else ""
        diagnostics.add(program.source, error.at, f"{error}{wanted}")
        arguments = []
    program.places[number] = len(program.statements)
    program.statements.append(Statement(number, row, arguments, text.strip(), at))


def _check(programs: Mapping[str, Program], known: Mapping[str, Location], diagnostics: Diagnostics) -> None:
    """Look whether all that programs name is there."""
    uses = [program.uses for program in programs.values()]
    locations = {word.text for one in uses for word in one.new_locations} | set(known)
    variables = {word.text for one in uses for word in one.new_variables}
    for program in programs.values():
        for word in program.uses.lines:
            if int(float(word.text)) not in program.places:
                diagnostics.add(program.source, word.at, f"there is no line {word.text} in {program.name}")
        for word in program.uses.programs:
            if word.text not in programs:
                hint = did_you_mean(word.text, programs)
                said = f"there is no program {word.text!r}{hint}; there are: {', '.join(programs)}"
                diagnostics.add(program.source, word.at, said)
        for word in program.uses.locations:
            if word.text not in locations:
                hint = did_you_mean(word.text, locations)
                said = f"there is no location {word.text!r}{hint}; no file of locations has it, and no HERE or SET"
                diagnostics.add(program.source, word.at, said)
        for word in program.uses.variables:
            if word.text not in variables:
                hint = did_you_mean(word.text, variables)
                diagnostics.add(program.source, word.at, f"nothing gives {word.text!r} a value{hint}")
