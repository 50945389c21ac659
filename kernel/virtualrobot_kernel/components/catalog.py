"""Catalogue of installed plugins and what they offer; those that fail are kept with the reason.

A plugin of another package than the kernel's is looked at in a worker process: it can raise, hang or crash there, and
its code comes into this process only when it offers a component that says so.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points

from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.loading import load
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.worker import Worker
from virtualrobot_sdk.worker.description import ComponentDescription, describe

from virtualrobot_kernel.errors import UnknownNameError

log = logging.getLogger(__name__)

OWN_PACKAGE = "virtualrobot"
"""Package whose plugins are trusted: the kernel's own."""

LOOK_SECONDS = 20.0
"""Deadline (s) for importing a plugin and its registration."""


@dataclass(frozen=True, slots=True, eq=False)
class Offer:
    """Component that a plugin offers; `registration` is None when the plugin was not imported into this process."""

    entry_point: EntryPoint
    about: ComponentDescription
    registration: Registration | None = None


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
        with ThreadPoolExecutor(max(1, len(points)), thread_name_prefix="plugins") as pool:
            found = tuple(pool.map(_looked_at, points))
        self._plugins = _without_clashes(found, _claims(self._plugins))
        for plugin in self._plugins:
            if plugin.reason:
                log.warning("the plugin %r of %s offers nothing: %s", plugin.name, plugin.package, plugin.reason)

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
    return point.dist.name if point.dist else ""


def _looked_at(point: EntryPoint) -> Plugin:
    """Return the plugin of an entry point; whatever goes wrong becomes the reason why it offers nothing."""
    found = Plugin(point.name, _package(point), point.dist.version if point.dist else "")
    try:
        if found.package == OWN_PACKAGE:
            return _loaded(found, point)
        with Worker(f"plugin {point.name}") as worker:
            description = worker.describe(point, deadline_seconds=LOOK_SECONDS)
        if any(component.isolation is Isolation.IN_PROCESS for component in description.components):
            return _loaded(found, point)
    except (PluginError, ComponentFault) as error:
        return replace(found, reason=str(error))
    offers = tuple(Offer(point, component) for component in description.components)
    return replace(found, api_version=description.api_version, offers=offers, models=description.models)


def _loaded(found: Plugin, point: EntryPoint) -> Plugin:
    """Return the plugin with its offers, imported into this process."""
    api_version, registrations, models = load(point)
    components = describe(api_version, registrations, models).components
    offers = tuple(Offer(point, about, one) for about, one in zip(components, registrations, strict=True))
    return replace(found, api_version=api_version, offers=offers, models=models)


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
