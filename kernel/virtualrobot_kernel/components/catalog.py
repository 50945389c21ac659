"""Catalogue of installed plugins and what they offer; those that fail are kept with the reason.

A plugin of another package than the kernel's is looked at in a worker process: it can raise, hang or crash there, and
its code comes into this process only when it offers a component that says so. What the kernel's own offer is
remembered from start to start (`components/remembered.py`), so that they are imported when they are used.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from importlib.metadata import Distribution, EntryPoint, entry_points

from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.loading import load
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.worker import Worker
from virtualrobot_sdk.worker.description import ComponentDescription, Description, describe

from virtualrobot_kernel.components import remembered
from virtualrobot_kernel.errors import UnknownNameError

log = logging.getLogger(__name__)

OWN_PACKAGE = "virtualrobot"
"""Package whose plugins are trusted: the kernel's own."""

LOOK_SECONDS = 20.0
"""Deadline (s) for importing a plugin and its registration."""


@dataclass(frozen=True, slots=True, eq=False)
class Offer:
    """Component that a plugin offers; `register` imports it, and is None where it is not for this process."""

    entry_point: EntryPoint
    about: ComponentDescription
    register: Callable[[], Registration] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Plugin:
    """Plugin by its entry point, with what it offers or the `reason` why that is nothing."""

    name: str
    package: str
    version: str
    api_version: str = ""
    offers: tuple[Offer, ...] = ()
    models: tuple[Model, ...] = ()
    reason: str = ""


class Catalog:
    """Catalogue of the plugins found last; `scan` looks again. Readers get one consistent catalogue or the next."""

    def __init__(self) -> None:
        """Find the plugins."""
        self._plugins: tuple[Plugin, ...] = ()
        self._own: list[EntryPoint] = []
        self.scan()

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """Return all plugins by name, the kernel's own first."""
        return self._plugins

    def scan(self) -> None:
        """Look for plugins again; a plugin that is loaded into this process already stays as it was."""
        points = sorted(
            entry_points(group=ENTRY_POINT_GROUP), key=lambda point: (_package(point) != OWN_PACKAGE, point.name)
        )
        own = [point for point in points if _package(point) == OWN_PACKAGE]
        recalled = remembered.recall(own)
        self._own = [] if recalled else own
        with ThreadPoolExecutor(max(1, len(points)), thread_name_prefix="plugins") as pool:
            found = tuple(pool.map(lambda point: _looked_at(point, recalled.get(point.name)), points))
        self._plugins = _without_clashes(found, _claims(self._plugins))
        for plugin in self._plugins:
            if plugin.reason:
                log.warning("the plugin %r of %s offers nothing: %s", plugin.name, plugin.package, plugin.reason)

    def remember(self) -> None:
        """Have the next start know what the kernel's own plugins offer, whose code is compiled; if none has failed."""
        if self._own and not any(plugin.reason for plugin in self._plugins if plugin.package == OWN_PACKAGE):
            remembered.remember(self._own, {point.name: describe(*_loaded(point)) for point in self._own})

    def load(self) -> None:
        """Import what was not yet imported of the plugins whose components work in this process."""
        for offer in (offer for plugin in self._plugins for offer in plugin.offers):
            if offer.register is not None and offer.about.isolation is Isolation.IN_PROCESS:
                try:
                    offer.register()
                except PluginError as error:  # whoever uses it is told the same
                    log.warning("the %s %r can't be loaded: %s", offer.about.kind.value, offer.about.name, error)

    def offers(self, kind: ComponentKind) -> dict[str, Offer]:
        """Return the components of a kind by name."""
        return {
            offer.about.name: offer for plugin in self._plugins for offer in plugin.offers if offer.about.kind is kind
        }

    @property
    def models(self) -> dict[str, Model]:
        """Return the models of all plugins by name."""
        models = (model for plugin in self._plugins for model in plugin.models)
        return {model.name: model for model in sorted(models, key=lambda model: model.name)}

    def find(self, kind: ComponentKind, name: str) -> Offer:
        """Return the component of a kind called `name`.

        Raises UnknownNameError, which also tells of plugins that have failed: one of them may have offered it.
        """
        offers = self.offers(kind)
        if name in offers:
            return offers[name]
        error = UnknownNameError(f"{kind.value} component", name, offers)
        failed = [f"the plugin {plugin.name!r} failed: {plugin.reason}" for plugin in self._plugins if plugin.reason]
        error.args = ("; ".join([str(error), *failed]),)
        raise error


def _package(point: EntryPoint) -> str:
    return _named(point.dist)[0] if point.dist else ""


@functools.lru_cache(maxsize=64)
def _named(package: Distribution) -> tuple[str, str]:
    """Return name and version of an installed package; a scan reads the file that tells them once for all plugins."""
    return package.name, package.version


def _looked_at(point: EntryPoint, recalled: Description | None) -> Plugin:
    """Return the plugin of an entry point; whatever goes wrong becomes the reason why it offers nothing."""
    found = Plugin(point.name, _package(point), _named(point.dist)[1] if point.dist else "")
    try:
        if found.package == OWN_PACKAGE:
            return _described(found, point, recalled or describe(*_loaded(point)), is_here=True)
        with Worker(f"plugin {point.name}") as worker:
            about = worker.describe(point, deadline_seconds=LOOK_SECONDS)
        is_here = any(component.isolation is Isolation.IN_PROCESS for component in about.components)
        return _described(found, point, describe(*_loaded(point)) if is_here else about, is_here)
    except (PluginError, ComponentFault) as error:
        return replace(found, reason=str(error))


def _described(found: Plugin, point: EntryPoint, about: Description, is_here: bool) -> Plugin:
    """Return the plugin with its offers; `is_here` says whether its code is for this process."""
    offers = tuple(
        Offer(point, one, functools.partial(_registration, point, one.kind, one.name) if is_here else None)
        for one in about.components
    )
    return replace(found, api_version=about.api_version, offers=offers, models=about.models)


def _registration(point: EntryPoint, kind: ComponentKind, name: str) -> Registration:
    """Return what a plugin registers by this name, imported now where it was not before."""
    for one in _loaded(point)[1]:
        if (one.kind, one.name) == (kind, name):
            return one
    raise PluginError(f"{point.value!r} was changed, and offers no {kind.value} component {name!r} any more")


@functools.cache
def _loaded(point: EntryPoint) -> tuple[str, tuple[Registration, ...], tuple[Model, ...]]:
    """Return what a plugin registers, imported into this process; once there it stays as it is."""
    return load(point)


Claim = tuple[ComponentKind | None, str]
"""Name among the components of its kind, ending of the files that importers read, or (of no kind) name of a model."""


def _claims(plugins: Iterable[Plugin]) -> dict[Claim, list[Plugin]]:
    """Return the plugins that offer each name and read each ending, in their order."""
    claims: dict[Claim, list[Plugin]] = {}
    for plugin in plugins:
        for about in (offer.about for offer in plugin.offers):
            for name in (about.name, *about.endings):
                claims.setdefault((about.kind, name), []).append(plugin)
        for model in plugin.models:
            claims.setdefault((None, model.name), []).append(plugin)
    return claims


def _without_clashes(plugins: tuple[Plugin, ...], before: Mapping[Claim, list[Plugin]]) -> tuple[Plugin, ...]:
    """Return the plugins; of several that claim a name or an ending one at most offers anything.

    It is the kernel's own, or else the one that had it in the catalog before this one. Where there is neither, none
    does: which of them robots mean by the name nobody can tell.
    """
    claims = _claims(plugins)
    reasons: dict[str, str] = {}
    for claim, claimants in claims.items():
        if len(claimants) == 1:
            continue
        held = [plugin.name for plugin in before.get(claim, ())]
        owner = next((p.name for p in claimants if p.package == OWN_PACKAGE or p.name in held), None)
        kind, name = claim
        for plugin in claimants:
            others = " and ".join(repr(p.name) for p in claimants if p is not plugin)
            by = f"by the plugin {owner!r} already" if owner else f"by {others} as well: uninstall all but one"
            if plugin.name != owner and name.startswith("."):
                reasons.setdefault(plugin.name, f"files {name!r} are read {by}")
            elif plugin.name != owner:
                choose = "; choose another name" if owner else ""
                what = f"{kind.value} component" if kind else "model"
                reasons.setdefault(plugin.name, f"the {what} {name!r} is offered {by}{choose}")
    return tuple(replace(p, offers=(), models=(), reason=reasons[p.name]) if p.name in reasons else p for p in plugins)
