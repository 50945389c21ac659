"""A component tried by laws on chains, with the processes that takes; both the pytest class and the grade use it."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, PluginError
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.testing import laws, manners
from virtualrobot_sdk.testing.bench import Bench
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.subject import Subject

Law = Callable[[Bench, np.random.Generator], Measured]

LAWS: dict[str, Law] = {
    "forward": laws.forward,
    "jacobian": laws.jacobian,
    "inverse": laws.inverse,
    "limits": laws.limits,
    "order": laws.order,
    "singular": laws.singular,
    "near": laws.near,
    "configurations": laws.configurations,
    "unreachable": laws.unreachable,
    "refusals": manners.refusals,
    "determinism": manners.determinism,
    "arguments": manners.arguments,
    "answers": manners.answers,
    "memory": manners.memory,
}
"""Laws of all kinematics components, by name, in the order in which they are tried."""


PATIENCE = 3
"""Number of faults that end the process after which nothing more is tried: each takes time, most have one cause."""


class State(Enum):
    """Result of a component for a law on a chain."""

    OK = "ok"
    FAILED = "failed"
    DECLINED = "declined"
    """The component is not made for this chain."""
    NOT_TRIED = "not tried"
    """It hung, crashed or grew too much: in the same law on another chain, or too often."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Finding of one law on one chain; `said` is what is wrong, or why it was not tried."""

    law: str
    chain: str
    state: State
    said: str = ""
    measured: Measured | None = None


class Examination:
    """Owns one worker process for each chain; they start when they are needed."""

    def __init__(self, subject: Subject, chains: Mapping[str, SerialChain], seed: int) -> None:
        """Take the component, the chains and the number that all random postures come from."""
        self.subject = subject
        self.chains = dict(chains)
        self.seed = seed
        self._benches: dict[str, Bench] = {}
        self._declined: dict[str, str] = {}
        self._not_made: Finding | None = None
        self._ends: dict[str, str] = {}

    def made(self, chain: str) -> Finding:
        """Return whether the component can be made for a chain."""
        if chain in self._declined:
            return Finding("made", chain, State.DECLINED, self._declined[chain])
        if self._not_made is not None:
            # Most likely it is the same for each chain, and making something that hangs takes long.
            if chain == self._not_made.chain:
                return self._not_made
            return Finding("made", chain, State.NOT_TRIED, f"it could not be made for {self._not_made.chain}")
        if chain not in self._benches:
            try:
                self._benches[chain] = Bench(self.subject, chain, self.chains[chain])
            except ArgumentError as error:
                self._declined[chain] = " ".join(str(error).split())
                return Finding("made", chain, State.DECLINED, self._declined[chain])
            except (ComponentFault, PluginError) as error:
                self._not_made = Finding("made", chain, State.FAILED, str(error))
                return self._not_made
        return Finding("made", chain, State.OK)

    def examine(self, name: str, law: Law, chain: str) -> Finding:
        """Return what comes of a law on a chain; equal seeds try equal postures."""
        made = self.made(chain)
        if made.state is not State.OK:
            return Finding(name, chain, made.state, made.said)
        if name in self._ends:
            return Finding(name, chain, State.NOT_TRIED, self._ends[name])
        if self.has_given_up:
            return Finding(name, chain, State.NOT_TRIED, f"its process has ended {PATIENCE} times")
        bench = self._benches[chain]
        said = ""
        try:
            bench.renew()
            measured = law(bench, self.random(name, chain))
            return Finding(name, chain, State.OK, measured=measured)
        except (LawBroken, ComponentFault, PluginError) as error:
            said = str(error)
        except ArgumentError as error:
            said = f"it refuses what is right: {error}"
        if bench.has_ended:
            self._ends[name] = f"on {chain}: {said}"
        return Finding(name, chain, State.FAILED, said)

    @property
    def has_given_up(self) -> bool:
        """True once so many processes have ended that nothing more is tried."""
        return len(self._ends) >= PATIENCE

    def cost(self, chain: str) -> tuple[Finding, dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Return for each method how long calls take (s), in its own process and through a worker.

        Where one fails, the finding says why, and there are no times.
        """
        if self.has_given_up:
            return Finding("cost", chain, State.NOT_TRIED), {}
        try:
            self._benches[chain].renew()
            seconds = manners.cost(self._benches[chain], self.random("cost", chain))
            return Finding("cost", chain, State.OK, measured=Measured(manners.COST_POSTURES)), seconds
        except (ArgumentError, ComponentFault, PluginError) as error:
            return Finding("cost", chain, State.FAILED, str(error)), {}

    def random(self, law: str, chain: str) -> np.random.Generator:
        """Return the numbers of a law on a chain: the same whichever other laws are tried."""
        return np.random.default_rng([self.seed, zlib.crc32(law.encode()), zlib.crc32(chain.encode())])

    def close(self) -> None:
        """End all processes."""
        for bench in self._benches.values():
            bench.close()
        self._benches.clear()
