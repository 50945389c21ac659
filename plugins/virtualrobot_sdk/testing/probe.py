"""A component under test in its worker process, and what can only be seen there: arguments, buffers, memory.

Each look has a name of its own for the errors, and gives plain data; `laws` judges it.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np
import psutil

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, PluginError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, Kinematics, SerialChain
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.settings import make_settings
from virtualrobot_sdk.worker.blame import describe_error, package_of, traceback_of


class Probe:
    """Owns the component; its errors name the line of the author's code."""

    def __init__(self, value: str, name: str, settings: Mapping[str, Any], chain: SerialChain) -> None:
        """Make the component for a chain.

        Args:
            value: the plugin's module, or with an empty `name` a factory as `module:attribute`.
            name: the name that the plugin registered.
            settings: plain values.
            chain: the chain that the component is made for.
        """
        self._package = package_of(value)
        self._component: Kinematics = self._contained("making it", _make, value, name, settings, chain)

    def forward(self, q: object) -> Floats:
        """Return what the component returns."""
        return self._contained("forward", self._component.forward, q)

    def jacobian(self, q: object) -> Floats:
        """Return what the component returns."""
        return self._contained("jacobian", self._component.jacobian, q)

    def inverse(self, target: object, options: InverseOptions) -> InverseResult:
        """Return what the component returns."""
        return self._contained("inverse", self._component.inverse, target, options)

    def written(self, q: Floats, target: Floats, seed: Floats) -> list[str]:
        """Return which arguments a call changed; a call with arguments that cannot be written to must work too."""
        changed = []
        given = q.copy(), target.copy(), seed.copy()
        for method, arguments in _calls(self, *given):
            method(*arguments)
            names = ("q", "the target", "the seed")
            for name, now, before in zip(names, given, (q, target, seed), strict=True):
                if not np.array_equal(now, before):
                    changed.append(f"{method.__name__} changes {name}")
                    now[...] = before
        if changed:
            return changed
        for array in given:
            array.setflags(write=False)
        for method, arguments in _calls(self, *given):
            method(*arguments)
        return changed

    def shared(self, first: Floats, second: Floats, target: Floats, other: Floats) -> list[str]:
        """Return which answers change with a later call, or change later answers when they are written to."""
        found = []
        for method, arguments, others in zip(
            (self.forward, self.jacobian, self._solutions), (first, first, target), (second, second, other), strict=True
        ):
            answer = method(arguments)
            kept = answer.copy()
            method(others)
            if answer.tobytes() != kept.tobytes():
                found.append(f"an answer of {_name(method)} changes with the next call")
            if method(arguments).tobytes() != kept.tobytes():
                found.append(f"{_name(method)} answers the same question otherwise after another one")
                continue
            if answer.flags.writeable:
                answer[...] = np.nan
            if method(arguments).tobytes() != kept.tobytes():
                found.append(f"who writes to an answer of {_name(method)} changes the next one")
        return found

    def memory(
        self, postures: Floats, targets: Floats, blocks: int, rounds_a_block: int, seconds: float
    ) -> tuple[list[int], list[int]]:
        """Return how many rounds were made and the process's memory (bytes) after each of some blocks of rounds.

        A round is one call of each method; where a block takes longer than its part of `seconds`, it has fewer. There
        is a block before that is not counted, since the first calls of anything take memory that stays.
        """
        process = psutil.Process()
        rounds, sizes = [0], []
        done = 0
        for _ in range(blocks + 1):
            ends = time.perf_counter() + seconds / (blocks + 1)
            for _ in range(rounds_a_block):
                if time.perf_counter() > ends:
                    break
                i = done % len(postures)
                for method, arguments in _calls(self, postures[i], targets[i], postures[i]):
                    method(*arguments)
                done += 1
            gc.collect()
            rounds.append(done)
            sizes.append(process.memory_info().rss)
        return rounds[1:], sizes

    def seconds(self, postures: Floats, targets: Floats) -> dict[str, list[float]]:
        """Return how long each method takes at each posture, the collector at rest, after one call that is not told."""
        found: dict[str, list[float]] = {}
        gc.disable()
        try:
            for i in range(-1, len(postures)):
                for method, arguments in _calls(self, postures[i], targets[i], postures[i]):
                    started = time.perf_counter()
                    method(*arguments)
                    if i >= 0:
                        found.setdefault(_name(method), []).append(time.perf_counter() - started)
        finally:
            gc.enable()
        return found

    def _solutions(self, target: Floats) -> Floats:
        return self.inverse(target, InverseOptions()).solutions

    def _contained(self, asked: str, function: Callable[..., Any], *arguments: object) -> Any:  # noqa: ANN401
        """Return what `function` returns; what it raises names the author's line and not this file's."""
        try:
            return function(*arguments)
        except (ArgumentError, PluginError, ComponentFault):
            raise
        except Exception as error:
            said = f"{asked} raised {describe_error(error, self._package)}"
            raise ComponentFault(FaultKind.RAISED, said, traceback_of(error)) from error


class Attribute:
    """Value of a module's attribute, or its result when called: the chains of an author."""

    def __init__(self, path: str) -> None:
        """Import `module:attribute`."""
        try:
            self._value = EntryPoint("", path, "").load()
        except (Exception, SystemExit) as error:
            raise PluginError(f"{path!r} cannot be imported: {describe_error(error, package_of(path))}") from error

    def value(self) -> object:
        """Return it."""
        return self._value() if callable(self._value) else self._value


def _make(value: str, name: str, settings: Mapping[str, Any], chain: SerialChain) -> Kinematics:
    from virtualrobot_sdk.loading import load

    if not name:
        return EntryPoint("", value, "").load()(chain)
    _, registrations, _ = load(EntryPoint(value, value, ENTRY_POINT_GROUP))
    one = next(r for r in registrations if r.kind is ComponentKind.KINEMATICS and r.name == name)
    made = make_settings(one.config_type, settings)
    return one.factory(chain) if one.config_type is None else one.factory(chain, made)


def _calls(
    probe: Probe, q: Floats, target: Floats, seed: Floats
) -> Sequence[tuple[Callable[..., Any], tuple[object, ...]]]:
    options = InverseOptions(seed=seed)
    return (probe.forward, (q,)), (probe.jacobian, (q,)), (probe.inverse, (target, options))


def _name(method: Callable[..., Any]) -> str:
    return method.__name__.replace("_solutions", "inverse")
