"""A component of any kind on trial: in a worker process of its own, tried by laws.

A law is a function of a trial and a generator of random numbers. It returns what it measured, raises LawBroken with the
numbers, or NotTried where it does not apply to this component.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FilesNeeded, PluginError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.bench import LOOK_SECONDS
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.subject import LOADING_SECONDS, Subject
from virtualrobot_sdk.worker import Worker

Facts = TypeVar("Facts")
"""Properties of a component that its author states, so that it can be tried; a dataclass for each kind."""
_STAGE = "virtualrobot_sdk.testing.stage:Stage"
_OWN_STAGES = {ComponentKind.ROBOT_DRIVER: "virtualrobot_sdk.testing.driver_stage:DriverStage"}
"""Stages of kinds whose components must be called in a rhythm, which only their own process keeps."""


class NotTried(Exception):
    """A law cannot be tried on this component; the message says why."""


class Trial(Generic[Facts]):
    """Owns the worker process in which a component is tried.

    `call` raises ArgumentError where the component does, and ComponentFault for whatever else goes wrong; so does a
    component that writes to its arguments, or to an answer that it gave before.
    """

    def __init__(self, kind: ComponentKind, subject: Subject, facts: Facts) -> None:
        """Make the component; raises what making it raises."""
        self.kind = kind
        self.subject = subject
        self.facts = facts
        self._worker = Worker(subject.component)
        try:
            self.make_anew()
        except BaseException:
            self._worker.close()
            raise

    def make_anew(self) -> None:
        """Make the component once more, in another process when a fault has ended the last one."""
        if self._worker.fault is not None:
            self._worker.close()
            self._worker = Worker(self.subject.component)
        made = self.kind, self.subject.value, self.subject.name, dict(self.subject.settings)
        stage = _OWN_STAGES.get(self.kind, _STAGE)
        self._worker.make_from(stage, *made, deadline_seconds=LOADING_SECONDS)

    def renew(self) -> None:
        """Make the component anew when a fault has ended its process."""
        if self._worker.fault is not None:
            self.make_anew()

    @property
    def has_ended(self) -> bool:
        """True once a fault has ended the process."""
        return self._worker.fault is not None

    def twin(self) -> Trial[Facts]:
        """Return another one, in another process."""
        return Trial(self.kind, self.subject, self.facts)

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  an answer that nobody has looked at
        """Return what the component answers, or its attribute of this name."""
        return self._worker.call(method, *arguments, deadline_seconds=self.subject.deadline_seconds)

    def call_within(self, seconds: float, method: str, *arguments: object) -> Any:  # noqa: ANN401
        """Return what a call answers that takes longer than a component's may."""
        return self._worker.call(method, *arguments, deadline_seconds=seconds)

    def seconds(self, times: int, method: str, *arguments: object) -> list[float]:
        """Return how long each of some equal calls takes in the component's own process."""
        return self._worker.call("seconds", method, arguments, times, deadline_seconds=LOOK_SECONDS)

    def touched(self) -> list[str]:
        """Return which files, hosts and processes the calls of an importer touched until now."""
        return self._worker.call("touched", deadline_seconds=LOOK_SECONDS)

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def __enter__(self) -> Trial[Facts]:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()


Law = Callable[[Trial[Any], np.random.Generator], Measured]
"""A rule that components of one kind keep."""


def examine(law: Law, trial: Trial[Any], seed: int) -> Measured:
    """Return what a law measured; equal seeds try equal values.

    Raises:
        LawBroken: the component broke it, or did what no component may.
        NotTried: it does not apply.
    """
    rng = np.random.default_rng([seed, zlib.crc32(law.__name__.encode())])
    try:
        trial.renew()
        return law(trial, rng)
    except (ArgumentError, FilesNeeded) as error:
        raise LawBroken(f"it refuses what is right: {error}") from error
    except (ComponentFault, PluginError) as error:
        raise LawBroken(str(error)) from error


def must_refuse(trial: Trial[Any], cases: Iterable[tuple[str, tuple[object, ...], str]]) -> int:
    """Make calls (method, arguments, what is wrong in words) that must be refused, and return how many.

    Raises LawBroken with those that were not.
    """
    accepted = []
    tried = 0
    for method, arguments, what in cases:
        tried += 1
        try:
            trial.call(method, *arguments)
        except ArgumentError:
            continue
        except ComponentFault as fault:
            accepted.append(f"{method} of {what}: {fault}")
            if trial.has_ended:
                break
            continue
        accepted.append(f"{method} of {what} was answered")
    if accepted:
        raise LawBroken(f"these must raise ArgumentError: {'; '.join(accepted)}")
    return tried


def checked(value: object, what: str, dtype: type, shape: tuple[int, ...]) -> np.ndarray:
    """Return `value` as it is when it is an array of this type and shape; raise LawBroken if not."""
    if not isinstance(value, np.ndarray) or value.dtype != dtype or value.shape != shape:
        found = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
        raise LawBroken(f"{what} is {found}; it must be an array of {np.dtype(dtype).name} {shape}")
    return value


def numbers(values: np.ndarray) -> str:
    """Return an array in short words for a message."""
    return "[" + ", ".join(f"{value:.6g}" for value in np.ravel(values)) + "]"
