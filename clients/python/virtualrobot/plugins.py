"""The kernel's plugins: which components they offer, where these run and how they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import settings_of, words_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import listed, shown, table_html, told
from virtualrobot.v1 import plugin_pb2

_KINDS = words_of(plugin_pb2.ComponentKind, "COMPONENT_KIND_")
_ISOLATIONS = words_of(plugin_pb2.Isolation, "ISOLATION_")
_STATES = words_of(plugin_pb2.PluginState, "PLUGIN_STATE_")


@shown
@dataclass(frozen=True, slots=True)
class ComponentUse:
    """A component at work.

    Attributes:
        robot: the robot that it works for; empty for a sensor's, and for an importer, which works for all.
        fault: its latest fault since it was chosen; empty while there was none.
        calls: number of calls that it has answered.
        mean_call_time: the mean time of a call.
        process_id: the number of its process on the kernel's machine; 0 when it runs in the kernel's own.
        sensor: the sensor that it works for; empty for a robot's and for an importer.
        group: the robot's group whose chain it solves, by name; empty for the robot's own chain.
    """

    robot: str
    fault: str
    calls: int
    mean_call_time: float
    process_id: int
    sensor: str = ""
    group: str = ""


@shown
@dataclass(frozen=True, slots=True)
class Component:
    """Component of a plugin.

    Attributes:
        kind: `kinematics`, `importer`, `mobile_kinematics`, `physics_engine`, `ray_caster`, `sensor_model`,
            `robot_driver` or `vehicle_dynamics`.
        name: unique among the components of its kind.
        description: one line about it.
        isolation: `in_process` (the kernel's own) or `process` (one of its own, with a deadline for each call).
        deadline: the longest that a call may take in a process of its own.
        settings_schema: the JSON schema of its settings; empty when it has none.
        endings: for importers: the endings of the files that it reads, such as `.step`.
        uses: its present uses.
    """

    kind: str
    name: str
    description: str
    isolation: str
    deadline: float
    settings_schema: dict[str, Any]
    endings: tuple[str, ...]
    uses: tuple[ComponentUse, ...]

    @staticmethod
    def of(message: plugin_pb2.Component) -> Component:
        """Return the component that a message tells."""
        return Component(
            _KINDS.get(message.kind, "unknown"),
            message.name,
            message.description,
            _ISOLATIONS.get(message.isolation, "unknown"),
            message.deadline_seconds,
            settings_of(message.settings_schema),
            tuple(message.endings),
            tuple(
                ComponentUse(
                    use.robot, use.fault, use.calls, use.mean_call_seconds, use.process_id, use.sensor, use.group
                )
                for use in message.uses
            ),
        )


@shown
@dataclass(frozen=True, slots=True)
class Plugin:
    """Plugin: the components of one entry point of a Python package.

    Attributes:
        name: the entry point's name.
        package: the Python package that it comes with.
        version: the package's version.
        api_version: the version of the plugin interface that it was written for; empty when that is not known.
        state: `loaded`, or `failed`: then it offers nothing.
        reason: the reason for which it failed; empty while it is well.
        components: the components that it offers.
    """

    name: str
    package: str
    version: str
    api_version: str
    state: str
    reason: str
    components: tuple[Component, ...]

    @property
    def ok(self) -> bool:
        """True where its components can be used."""
        return self.state == "loaded"

    @staticmethod
    def of(message: plugin_pb2.Plugin) -> Plugin:
        """Return the plugin that a message tells."""
        return Plugin(
            message.name,
            message.package,
            message.version,
            message.api_version,
            _STATES.get(message.state, "unknown"),
            message.reason,
            tuple(map(Component.of, message.components)),
        )


@checked
class Plugins:
    """The plugins of one kernel; it can be iterated over. Each question is asked anew.

    Example:
        >>> [plugin.name for plugin in client.plugins if not plugin.ok]
        []
        >>> [component.name for component in client.plugins.components("kinematics")]
        ['chain', 'closed_form', 'dh']
    """

    def __init__(self, services: Services) -> None:
        """Handle the plugins of one kernel."""
        self._services = services

    def list(self) -> tuple[Plugin, ...]:
        """Return all plugins that are installed, by name, those that failed included."""
        response = self._services.plugin.ListPlugins(plugin_pb2.ListPluginsRequest())
        return tuple(map(Plugin.of, response.plugins))

    def reload(self) -> tuple[Plugin, ...]:
        """Look for plugins again, so that one installed since the kernel's start is found; return all.

        Components at work go on.
        """
        response = self._services.plugin.ReloadPlugins(plugin_pb2.ReloadPluginsRequest(), timeout=LONG_TIMEOUT_SECONDS)
        return tuple(map(Plugin.of, response.plugins))

    def components(self, kind: str = "") -> tuple[Component, ...]:
        """Return the components of all plugins, or those of one kind, such as `kinematics`."""
        return tuple(
            component for plugin in self for component in plugin.components if not kind or component.kind == kind
        )

    def __iter__(self) -> Iterator[Plugin]:
        """Yield the plugins by name."""
        return iter(self.list())

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            every = self.list()
            failed = [plugin.name for plugin in every if not plugin.ok]
            count = sum(len(plugin.components) for plugin in every)
            return f"{len(every)} with {count} components; {listed(failed, 'none')} failed"

        return told("Plugins", say)

    def _repr_html_(self) -> str:
        """Return a table of the components for notebooks."""
        rows = [[one.kind, one.name, one.description] for one in self.components()]
        return table_html("Components", [["kind", "component", "description"], *rows])
