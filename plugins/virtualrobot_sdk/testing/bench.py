"""Test bench of a component: a worker process of its own, so that a hang or a crash is found and named."""

from __future__ import annotations

import time
from typing import Any

from virtualrobot_sdk.answers import checked_frames, checked_jacobian, checked_result
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain
from virtualrobot_sdk.reference import tip_pose
from virtualrobot_sdk.testing.subject import LOADING_SECONDS, Subject
from virtualrobot_sdk.worker import Worker

LOOK_SECONDS = 30.0
"""Deadline of the kit's own loops of many calls (s)."""
_PROBE = "virtualrobot_sdk.testing.probe:Probe"


class Bench:
    """Owns the worker process in which a subject is tried on one chain; every answer is looked at before it is given.

    Its methods raise ArgumentError where the component does, and ComponentFault for whatever else goes wrong. After a
    fault that ended the process, `renew` makes another.
    """

    def __init__(self, subject: Subject, chain_name: str, chain: SerialChain) -> None:
        """Make the component; an ArgumentError declines the chain, a ComponentFault says what went wrong."""
        self.subject = subject
        self.chain_name = chain_name
        self.chain = chain
        self._worker = self._started()

    @property
    def has_ended(self) -> bool:
        """True once a fault has ended the process."""
        return self._worker.fault is not None

    def renew(self) -> None:
        """Make the component anew when a fault has ended its process."""
        if self.has_ended:
            self._worker.close()
            self._worker = self._started()

    def twin(self) -> Bench:
        """Return another one, in another process."""
        return Bench(self.subject, self.chain_name, self.chain)

    def forward(self, q: Floats) -> Floats:
        """Return the frames (m, 4, 4)."""
        return checked_frames(self.call("forward", q))

    def jacobian(self, q: Floats) -> Floats:
        """Return the Jacobian (6, k)."""
        return checked_jacobian(self.call("jacobian", q), self.chain)

    def inverse(self, target: Floats, options: InverseOptions) -> InverseResult:
        """Return the solutions."""
        return checked_result(self.call("inverse", target, options), self.chain, options)

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  an answer that nobody has looked at
        """Return what the component answers, as it is."""
        return self._worker.call(method, *arguments, deadline_seconds=self.subject.deadline_seconds)

    def look(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  each look gives something else
        """Return what a look of the probe's gives, which takes many calls."""
        return self._worker.call(method, *arguments, deadline_seconds=LOOK_SECONDS)

    def seconds(self, postures: Floats, targets: Floats) -> dict[str, list[float]]:
        """Return how long each method takes at each posture, asked from this process."""
        found: dict[str, list[float]] = {"forward": [], "jacobian": [], "inverse": []}
        for q, target in zip(postures, targets, strict=True):
            solving = target, InverseOptions(seed=q)
            for method, arguments in (("forward", (q,)), ("jacobian", (q,)), ("inverse", solving)):
                started = time.perf_counter()
                self.call(method, *arguments)
                found[method].append(time.perf_counter() - started)
        return found

    def tip(self, q: Floats) -> Floats:
        """Return where the chain has its tip (4, 4), by the kit's own forward pass."""
        return tip_pose(self.chain, q)

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def __enter__(self) -> Bench:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _started(self) -> Worker:
        worker = Worker(f"{self.subject.component} on {self.chain_name}")
        given = self.subject.value, self.subject.name, dict(self.subject.settings), self.chain
        try:
            worker.make_from(_PROBE, *given, deadline_seconds=LOADING_SECONDS)
        except BaseException:
            worker.close()
            raise
        return worker


def own_chains(path: str) -> dict[str, SerialChain]:
    """Return the chains that a module has at `module:attribute`: a dictionary by name, or a function that makes one.

    Raises PluginError and ComponentFault as an import does, and PluginError for anything else than chains by name.
    """
    with Worker(path) as worker:
        worker.make_from("virtualrobot_sdk.testing.probe:Attribute", path, deadline_seconds=LOADING_SECONDS)
        found = worker.call("value", deadline_seconds=LOADING_SECONDS)
    if not isinstance(found, dict) or not found or not all(isinstance(c, SerialChain) for c in found.values()):
        raise PluginError(f"{path} is {type(found).__name__}; it must be SerialChains by name")
    return found
