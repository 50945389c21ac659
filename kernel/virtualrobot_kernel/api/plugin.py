"""PluginService: installed plugins, and the state of their components."""

from __future__ import annotations

import asyncio

from google.protobuf.struct_pb2 import Struct
from virtualrobot.v1 import plugin_pb2, plugin_pb2_grpc
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.worker.description import ComponentDescription

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.components.catalog import Plugin
from virtualrobot_kernel.sensing.sensor_status import at_work

KINDS = {
    ComponentKind.KINEMATICS: plugin_pb2.COMPONENT_KIND_KINEMATICS,
    ComponentKind.IMPORTER: plugin_pb2.COMPONENT_KIND_IMPORTER,
    ComponentKind.MOBILE_KINEMATICS: plugin_pb2.COMPONENT_KIND_MOBILE_KINEMATICS,
    ComponentKind.RAY_CASTER: plugin_pb2.COMPONENT_KIND_RAY_CASTER,
    ComponentKind.SENSOR_MODEL: plugin_pb2.COMPONENT_KIND_SENSOR_MODEL,
    ComponentKind.ROBOT_DRIVER: plugin_pb2.COMPONENT_KIND_ROBOT_DRIVER,
}
ISOLATIONS = {
    Isolation.IN_PROCESS: plugin_pb2.ISOLATION_IN_PROCESS,
    Isolation.PROCESS: plugin_pb2.ISOLATION_PROCESS,
}

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
        await asyncio.get_running_loop().run_in_executor(self._kernel.workers, self._kernel.catalog.scan)
        return plugin_pb2.ReloadPluginsResponse(plugins=self._plugins())

    def _plugins(self) -> list[plugin_pb2.Plugin]:
        uses = self._uses()
        return [_plugin_message(plugin, uses) for plugin in self._kernel.catalog.plugins]

    def _uses(self) -> Uses:
        """Return the users of each component, robots and sensors by name."""
        uses: Uses = {}
        for use in self._kernel.solvers.uses(self._kernel.world.snapshot.structure):
            uses.setdefault((ComponentKind.KINEMATICS, use.kinematics), []).append(
                plugin_pb2.ComponentUse(
                    robot=use.robot,
                    group=use.group,
                    fault=use.fault,
                    calls=use.calls,
                    mean_call_seconds=use.mean_call_seconds,
                    process_id=use.process_id,
                )
            )
        for use in at_work(self._kernel.sensors, self._kernel.world.snapshot.structure):
            about, fault = use.running.offer.about, use.running.latest
            uses.setdefault((about.kind, about.name), []).append(
                plugin_pb2.ComponentUse(
                    sensor=use.sensor,
                    fault=fault.reason if fault else "",
                    calls=use.running.calls,
                    mean_call_seconds=use.running.mean_seconds,
                    process_id=0 if use.running.fault else use.running.process_id,
                )
            )
        for running in (*self._kernel.importers.uses(), *self._kernel.casters.uses()):
            uses.setdefault((running.offer.about.kind, running.offer.about.name), []).append(
                plugin_pb2.ComponentUse(
                    fault=running.latest.reason if running.latest else "",
                    calls=running.calls,
                    mean_call_seconds=running.mean_seconds,
                    process_id=0 if running.fault else running.process_id,
                )
            )
        return uses


def _plugin_message(plugin: Plugin, uses: Uses) -> plugin_pb2.Plugin:
    return plugin_pb2.Plugin(
        name=plugin.name,
        package=plugin.package,
        version=plugin.version,
        api_version=plugin.api_version,
        state=plugin_pb2.PLUGIN_STATE_FAILED if plugin.reason else plugin_pb2.PLUGIN_STATE_LOADED,
        reason=plugin.reason,
        components=[
            _component_message(offer.about, uses.get((offer.about.kind, offer.about.name), []))
            for offer in plugin.offers
        ],
    )


def _component_message(about: ComponentDescription, uses: list[plugin_pb2.ComponentUse]) -> plugin_pb2.Component:
    schema = None
    if about.settings_schema:
        schema = Struct()
        schema.update(about.settings_schema)
    return plugin_pb2.Component(
        kind=KINDS[about.kind],
        name=about.name,
        description=about.description,
        isolation=ISOLATIONS[about.isolation],
        deadline_seconds=about.deadline_seconds,
        settings_schema=schema,
        endings=about.endings,
        uses=uses,
    )
