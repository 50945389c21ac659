"""Plugins, components and self-checks as values and tables."""

from __future__ import annotations

import re

from virtualrobot._wire.messages import settings_message
from virtualrobot.cli.plugins import describe
from virtualrobot.plugins import Component, ComponentUse, Plugin
from virtualrobot.robots.kinematics_check import KinematicsCheck
from virtualrobot.v1 import plugin_pb2, robot_pb2
from virtualrobot_sdk.registration import ComponentKind

SCHEMA = {"type": "object", "properties": {"gain": {"type": "number", "default": 0.5}}}
WELL = plugin_pb2.Plugin(
    name="arms",
    package="arm-package",
    version="1.2",
    api_version="1.0",
    state=plugin_pb2.PLUGIN_STATE_LOADED,
    components=[
        plugin_pb2.Component(
            kind=plugin_pb2.COMPONENT_KIND_KINEMATICS,
            name="my_arm",
            description="Solves my arm.",
            isolation=plugin_pb2.ISOLATION_PROCESS,
            deadline_seconds=0.5,
            settings_schema=settings_message(SCHEMA),
            uses=[
                plugin_pb2.ComponentUse(robot="left", calls=20, mean_call_seconds=0.0015, process_id=77),
                plugin_pb2.ComponentUse(robot="right", fault="forward did not answer within 0.5 s"),
            ],
        ),
        plugin_pb2.Component(
            kind=plugin_pb2.COMPONENT_KIND_IMPORTER,
            name="my_format",
            isolation=plugin_pb2.ISOLATION_IN_PROCESS,
            deadline_seconds=60,
            endings=[".mine", ".my"],
        ),
    ],
)
FAILED = plugin_pb2.Plugin(
    name="broken", package="b", version="0.1", state=plugin_pb2.PLUGIN_STATE_FAILED, reason="cannot be imported"
)


def test_a_plugin_tells_what_its_message_tells() -> None:
    plugin = Plugin.of(WELL)
    assert (plugin.name, plugin.package, plugin.version, plugin.api_version) == ("arms", "arm-package", "1.2", "1.0")
    assert (plugin.ok, plugin.state, plugin.reason) == (True, "loaded", "")
    arm, importer = plugin.components
    assert arm == Component(
        "kinematics",
        "my_arm",
        "Solves my arm.",
        "process",
        0.5,
        SCHEMA,
        (),
        (
            ComponentUse("left", "", 20, 0.0015, 77),
            ComponentUse("right", "forward did not answer within 0.5 s", 0, 0.0, 0),
        ),
    )
    assert (importer.kind, importer.isolation, importer.endings) == ("importer", "in_process", (".mine", ".my"))
    assert importer.settings_schema == {}
    failed = Plugin.of(FAILED)
    assert (failed.ok, failed.state, failed.reason, failed.components) == (False, "failed", "cannot be imported", ())


def test_every_kind_of_the_contract_has_a_word() -> None:
    """The same as in the SDK."""
    names = [name for name in plugin_pb2.ComponentKind.keys() if not name.endswith("_UNSPECIFIED")]
    words = [Component.of(plugin_pb2.Component(kind=name)).kind for name in names]
    assert set(words) == {kind.value for kind in ComponentKind}
    assert Component.of(plugin_pb2.Component()).kind == "unknown"


def test_plugins_are_shown_as_a_table() -> None:
    plugins = [Plugin.of(WELL), Plugin.of(FAILED)]
    assert "\n".join(describe(plugins, settings=True)) == (
        "arms 1.2 (arm-package)  loaded\n"
        "  kinematics  my_arm     process, 0.5 s a call             Solves my arm.\n"
        "    for left: 20 calls of 1.500 ms, process 77\n"
        "    for right: 0 calls, not asked any more: forward did not answer within 0.5 s\n"
        "    gain: number [0.5]\n"
        "  importer    my_format  in process             .mine .my\n"
        "broken 0.1 (b)  failed: cannot be imported"
    )
    assert "gain" not in "\n".join(describe(plugins, settings=False))
    assert list(describe([Plugin.of(FAILED)], settings=False)) == ["broken 0.1 (b)  failed: cannot be imported"]
    assert list(describe([], settings=False)) == []


def test_a_check_has_every_number_of_the_message() -> None:
    names = [field.name for field in robot_pb2.KinematicsCheck.DESCRIPTOR.fields]
    message = robot_pb2.KinematicsCheck(**{name: number for number, name in enumerate(names, 1)})
    check = KinematicsCheck.of(message)
    fields = [re.sub("_meters|_radians", "", name).replace("_seconds", "_time") for name in names]
    assert [getattr(check, name) for name in fields] == list(range(1, len(names) + 1))


def test_a_check_is_shown_as_a_table() -> None:
    check = KinematicsCheck(8, 1.2e-16, 2e-16, 3e-7, 4e-8, 5.5e-10, 2e-6, 3e-6, 5e-5)
    assert repr(check) == (
        "8 postures           position     rotation    a call\n"
        "forward             1.2e-16 m  2.0e-16 rad  0.002 ms\n"
        "inverse             3.0e-07 m  4.0e-08 rad  0.050 ms\n"
        "jacobian, relative    5.5e-10               0.003 ms"
    )
