"""The contract suite for importers: native formats that open, equal bytes each time, nothing but refusals of damage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FilesNeeded
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.damage import damaged
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.native_formats import check_native
from virtualrobot_sdk.testing.trial import Law, Trial

ROUNDS = 1000
"""Largest number of times that an importer may ask for more files of one sample."""
_MOST_TOLD = 5


@dataclass(frozen=True, slots=True)
class ImporterFacts:
    """Properties of an importer that its author states.

    Attributes:
        samples: good files by their names, with the ending; small ones, since each is read many times.
        files: files that the samples name, by name as written; what is not here is nowhere.
        damaged: number of damaged copies of each sample that are tried.
        uses_processes: true where it runs a converter in a process of its own, with files in the temporary folder.
    """

    samples: Mapping[str, bytes]
    files: Mapping[str, bytes] = field(default_factory=dict)
    damaged: int = 60
    uses_processes: bool = False


ImporterTrial = Trial[ImporterFacts]


def formats(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """Each sample becomes a file of a native format that opens."""
    size = 0
    for name, data in trial.facts.samples.items():
        size += len(_translated(trial, data, name, trial.facts.files).data)
    return Measured(len(trial.facts.samples), {"bytes": size})


def missing(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """Files that are named and are nowhere are asked for once; then there is a translation, or a refusal."""
    for name, data in trial.facts.samples.items():
        try:
            _translated(trial, data, name, {})
        except ArgumentError as error:
            _has_words(error, f"{name} without the files that it names")
    return Measured(len(trial.facts.samples))


def determinism(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """A file gives the same bytes each time, in another process too, where sets have another order."""
    with trial.twin() as twin:
        for name, data in trial.facts.samples.items():
            first = _translated(trial, data, name, trial.facts.files)
            for where, other in (("", trial), (" in another process", twin)):
                if _translated(other, data, name, trial.facts.files) != first:
                    raise LawBroken(f"{name} gives another translation the next time{where}")
    return Measured(2 * len(trial.facts.samples))


def nonsense(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """An empty file and noise are refused."""
    tried = 0
    for name in trial.facts.samples:
        for what, data in (("an empty file", b""), ("noise", rng.bytes(500)), ("zeros", bytes(500))):
            tried += 1
            try:
                _translated(trial, data, name, {})
            except ArgumentError as error:
                _has_words(error, what)
                continue
            raise LawBroken(f"{what} called {name} was translated; it must be refused by an ArgumentError")
    return Measured(tried)


def damage(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """Damaged files are refused by an ArgumentError, or give a native format that opens: nothing else comes of them."""
    said: list[str] = []
    refused = tried = 0
    for name, data in trial.facts.samples.items():
        for _ in range(trial.facts.damaged):
            broken, what = damaged(data, rng)
            tried += 1
            try:
                _translated(trial, broken, name, trial.facts.files, is_whole=False)
            except ArgumentError as error:
                refused += 1
                _has_words(error, f"{name}, {what}")
            except (ComponentFault, LawBroken) as error:
                said.append(f"{name}, {what}: {error}")
                if trial.has_ended or len(said) == _MOST_TOLD:
                    raise _harmed(said) from error
    if said:
        raise _harmed(said)
    return Measured(tried, {"refused": refused})


def seclusion(trial: ImporterTrial, rng: np.random.Generator) -> Measured:
    """It reads no file, speaks with no other machine and starts no process; what it needs its caller gives it.

    What an importer that starts a converter does in the temporary folder is its own affair.
    """
    for files in (trial.facts.files, *([{}] if trial.facts.files else [])):
        for name, data in trial.facts.samples.items():
            try:
                _translated(trial, data, name, files)
            except (ArgumentError, ComponentFault, LawBroken):
                continue  # perhaps it was kept from what it wanted; the other laws judge its answers
    allowed = ("process:", "scratch:") if trial.facts.uses_processes else ()
    if found := [event for event in trial.touched() if not event.startswith(allowed)]:
        raise LawBroken(f"an importer gets all that it reads from its caller; this one: {', '.join(found)}")
    return Measured(len(trial.facts.samples))


LAWS: Mapping[str, Law] = MappingProxyType(
    {law.__name__: law for law in (formats, missing, determinism, nonsense, damage, seclusion)}
)
"""Laws of all importers, by name, in the order in which they are tried."""


class ImporterContract(ComponentContract):
    """Contract of all importers; subclass it in a test file.

    class TestMyFormat(ImporterContract):
        component = "my_package/my_format"
        facts = ImporterFacts({"cube.mine": Path("tests/cube.mine").read_bytes()})
    """

    kind = ComponentKind.IMPORTER
    laws = LAWS
    facts: ClassVar[ImporterFacts]


def _translated(
    trial: ImporterTrial, data: bytes, name: str, files: Mapping[str, bytes], *, is_whole: bool = True
) -> Translation:
    """Return what an importer makes of a file, given the files that it asks for; None for one that is not in `files`.

    Raises LawBroken where it asks for a file twice, or for ever.
    """
    given: dict[str, bytes | None] = {}
    for _ in range(ROUNDS):
        try:
            return check_native(trial.call("translate", data, name, given), name, is_whole=is_whole)
        except FilesNeeded as needed:
            again = [one for one in needed.names if one in given]
            if again or not needed.names or not all(needed.names):
                asked = ", ".join(map(repr, again or needed.names)) or "no file"
                raise LawBroken(f"for {name} it asks for {asked}{' again' if again else ''}") from needed
            given.update({one: files.get(one) for one in needed.names})
    raise LawBroken(f"for {name} it asked for more files {ROUNDS} times")


def _harmed(said: list[str]) -> LawBroken:
    return LawBroken(f"damage must be refused by an ArgumentError: {'; '.join(dict.fromkeys(said))}")


def _has_words(error: ArgumentError, what: str) -> None:
    if not error.message.strip():
        raise LawBroken(f"the refusal of {what} has no words; it must say where and why")
