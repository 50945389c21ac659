"""PluginService: installed plugins, and the state of their components."""

from __future__ import annotations

from virtualrobot.v1 import plugin_pb2, plugin_pb2_grpc
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.worker.description import ComponentDescription

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.components.catalog import Plugin
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.planning.solvers import Use
from virtualrobot_kernel.sensing.sensor_status import at_work

COMPONENT = Table(
    ComponentDescription,
    plugin_pb2.Component,
    kind=EnumTable(ComponentKind, plugin_pb2.ComponentKind),
    isolation=EnumTable(Isolation, plugin_pb2.Isolation),
    without=("uses",),
)
PLUGIN = Table(Plugin, plugin_pb2.Plugin, without=("offers", "models", "state", "components"))
USE = Table(Use, plugin_pb2.ComponentUse, without=("kinematics", "sensor"))

Uses = dict[tuple[ComponentKind, str], list[plugin_pb2.ComponentUse]]


class PluginServicer(plugin_pb2_grpc.PluginServiceServicer):
    """Servicer of PluginService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def ListPlugins(
        self, request: plugin_pb2.ListPluginsRequest, context: object
    ) -> plugin_pb2.ListPluginsResponse:
        """Tell all plugins and how their components are."""
        return plugin_pb2.ListPluginsResponse(plugins=self._plugins())

    async def ReloadPlugins(
        self, request: plugin_pb2.ReloadPluginsRequest, context: object
    ) -> plugin_pb2.ReloadPluginsResponse:
        """Look for plugins again, in a worker thread."""
        await self._kernel.in_worker(self._kernel.catalog.scan)
        return plugin_pb2.ReloadPluginsResponse(plugins=self._plugins())

    def _plugins(self) -> list[plugin_pb2.Plugin]:
        uses = self._uses()
        return [_plugin_message(plugin, uses) for plugin in self._kernel.catalog.plugins]

    def _uses(self) -> Uses:
        """Return the users of each component, robots and sensors by name."""
        uses: Uses = {}
        for use in self._kernel.solvers.uses(self._kernel.world.snapshot.structure):
            uses.setdefault((ComponentKind.KINEMATICS, use.kinematics), []).append(USE.write(use))
        sensors = at_work(self._kernel.sensors, self._kernel.world.snapshot.structure)
        others = (*self._kernel.importers.uses(), *self._kernel.casters.uses(), *self._kernel.forces.uses())
        for sensor, running in (*((use.sensor, use.running) for use in sensors), *(("", one) for one in others)):
            uses.setdefault((running.offer.about.kind, running.offer.about.name), []).append(
                plugin_pb2.ComponentUse(
                    sensor=sensor,
                    fault=running.latest.reason if running.latest else "",
                    calls=running.calls,
                    mean_call_seconds=running.mean_seconds,
                    process_id=0 if running.fault else running.process_id,
                )
            )
        return uses


def _plugin_message(plugin: Plugin, uses: Uses) -> plugin_pb2.Plugin:
    return PLUGIN.write(
        plugin,
        state=plugin_pb2.PLUGIN_STATE_FAILED if plugin.reason else plugin_pb2.PLUGIN_STATE_LOADED,
        components=[
            COMPONENT.write(offer.about, uses=uses.get((offer.about.kind, offer.about.name), ()))
            for offer in plugin.offers
        ],
    )
