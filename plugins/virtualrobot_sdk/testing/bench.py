"""Where a component is tried: a worker process of its own, so that a hang or a crash is found and named."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from virtualrobot_sdk.answers import checked_frames, checked_jacobian, checked_result
from virtualrobot_sdk.errors import ArgumentError, ComponentFault, PluginError
from virtualrobot_sdk.hookspecs import COMPONENT_DEADLINE_SECONDS, ENTRY_POINT_GROUP
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain
from virtualrobot_sdk.reference import tip_pose
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.worker import ComponentDescription, Worker

LOADING_SECONDS = 20.0
"""How long a plugin may take to be imported, and a component to be made."""
LOOK_SECONDS = 30.0
"""How long the kit's own loops of many calls may take."""
_PROBE = "virtualrobot_sdk.testing.probe:Probe"


@dataclass(frozen=True, slots=True)
class Subject:
    """A component that is tried, and how it is made.

    Attributes:
        component: as its author writes it.
        value: the plugin's module, or a factory as `module:attribute`.
        name: what the plugin registered; empty for a factory.
        settings: plain values.
        deadline_seconds: the longest that a call may take.
    """

    component: str
    value: str
    name: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    deadline_seconds: float = COMPONENT_DEADLINE_SECONDS


def find(component: str, settings: Mapping[str, Any] | None = None) -> Subject:
    """Return the component of this name, looked for in processes that a broken plugin may hang or crash.

    Args:
        component: `my_arm` (of an installed plugin), `my_package/my_arm` (the plugin's module and the component's
            name) or `my_package.arm:MyArm` (something that makes the component of a chain, without settings).
        settings: plain values.

    Raises:
        PluginError: there is none, or its plugin fails; says which plugins do and why.
        ComponentFault: its plugin hangs or crashes when it is imported.
    """
    settings = dict(settings or {})
    module, slash, name = component.rpartition("/")
    if ":" in component and not slash:
        if settings:
            raise PluginError(f"{component!r} takes no settings; name its plugin: MODULE/COMPONENT")
        return Subject(component, component, "")
    if slash:
        found = _offers(EntryPoint(module, module, ENTRY_POINT_GROUP))
        if name not in found:
            raise PluginError(f"{module!r} registers no kinematics {name!r}; it has {', '.join(found) or 'none'}")
        return Subject(component, module, name, settings, found[name].deadline_seconds)
    known, failed = [], []
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            found = _offers(point)
        except (PluginError, ComponentFault) as error:
            failed.append(f"; plugin {point.name!r} failed: {error}")
            continue
        if name in found:
            return Subject(component, point.value, name, settings, found[name].deadline_seconds)
        known += found
    raise PluginError(f"no plugin has kinematics {name!r}; there are {', '.join(known)}{''.join(failed)}")


def _offers(point: EntryPoint) -> dict[str, ComponentDescription]:
    with Worker(point.name) as worker:
        description = worker.describe(point, deadline_seconds=LOADING_SECONDS)
    return {c.name: c for c in description.components if c.kind is ComponentKind.KINEMATICS}


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
        """Whether a fault has ended the process."""
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


def declined(error: ArgumentError) -> str:
    """Return why a component declines a chain, in one line."""
    return " ".join(str(error).split())
