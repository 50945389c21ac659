"""Write the table of all functions by what they are for: `python tools/generate_functions.py [file]`.

What the Python library has is read from its classes, what the contract has from its descriptors, and the commands from
the command line itself. Each has its group here; whatever has none is an error, so that nothing is missing.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import virtualrobot
from virtualrobot import cli
from virtualrobot.v1 import scene_pb2

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "functions.md"
PROTO = ROOT / "proto" / "virtualrobot" / "v1"

HEAD = """<!-- Written by tools/generate_functions.py from the code; run it again instead of changing this page. -->
# All functions, by what they are for

The groups are those of VirtualRobot's external access library (VReal), whose more than 250 functions of C and C++ let
programs do everything from outside: opening and closing, files, robots, auxiliary figures, the user interface, distance
and collision, range sensors. Two more hold what it had not. Here are {python} functions of the Python library, {calls}
calls of the contract and {batch} commands of its batches, which any language has, and {shell} commands of the shell. A
program reaches a kernel by TCP, `virtualrobot.connect(address)`, or has its own, `virtualrobot.connect("local")`.

`client` is what `connect` returns; `robot`, `node`, `motion` and so on are what its functions return.
"""


@dataclass(frozen=True)
class Group:
    """Group of functions.

    services: of the contract; batch: commands of `Apply`. python: class by what a program calls its object,
    `module:Class`; functions: names of the module `virtualrobot`; client: members of `Client`. commands: of the shell.
    """

    title: str
    services: tuple[str, ...] = ()
    batch: tuple[str, ...] = ()
    python: Mapping[str, str] = field(default_factory=dict)
    functions: tuple[str, ...] = ()
    client: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()


GROUPS = (
    Group(
        "Open and close",
        services=("KernelService", "LeaseService", "TokenService"),
        python={
            "client.clock": "clock:Clock",
            "client.tokens": "tokens:Tokens",
            "lease": "leases:Lease",
            "kernel": "kernel_process:KernelProcess",
        },
        functions=("connect",),
        client=("close", "lease", "leases", "watch_leases", "report", "services", "shutdown"),
        commands=(
            "serve",
            "console",
            "shell",
            "report",
            "repair",
            "lease",
            "leases",
            "token",
            "clock",
            "step",
            "state",
        ),
    ),
    Group(
        "Files: robots, environments, scenes",
        services=("AssetService", "SceneService"),
        batch=("CreateNode", "UpdateNode", "RemoveNode", "AttachNode", "SetGroups", "SetPostures"),
        python={"client.scene": "scene.scene:Scene", "node": "scene.node:Node", "client.assets": "files.assets:Assets"},
        client=("load_denavit_hartenberg", "load_robot", "models"),
        commands=(
            "load",
            "models",
            "model",
            "save",
            "export",
            "ls",
            "add",
            "rename",
            "describe",
            "attach",
            "remove",
            "new",
        ),
    ),
    Group(
        "Robots",
        services=("RobotService", "MotionService", "ProposalService", "PathService", "CalibrationService"),
        batch=(
            *("PickPart", "PlacePart", "SetJointPositions", "SelectTool", "SetToolState", "SetSpeedFactor"),
            *("KinematicsChoice", "MountTool", "UnmountTool", "SetTcpSpeedLimit", "SetCraft"),
        ),
        python={
            "client.robots": "robots.robots:Robots",
            "robot": "robots.robot:Robot",
            "robot.group(...)": "robots.group:Group",
            "robot.tool": "robots.tool:Tool",
            "robot.calibration": "robots.calibration:Calibration",
            "target": "scene.target:Target",
            "motion": "motions.motion:Motion",
            "plan": "motions.plans:MotionPlan",
            "program": "motions.program:Program",
            "stream": "motions.setpoints:SetpointStream",
            "client.proposals": "motions.proposals:Proposals",
            "client.tasks": "tasks:Tasks",
            "client.paths": "motions.paths:Paths",
            "tool_path": "motions.tool_paths:ToolPath",
        },
        functions=("inertial", "path_frames"),
        client=(
            *("check", "check_plan", "motions", "move_together", "plan", "program", "read_program", "robot"),
            *("speed_factor", "start_plan", "stop", "targets", "watch_motions"),
        ),
        commands=(
            *(
                "move",
                "plan",
                "check",
                "start",
                "proposal",
                "path",
                "process",
                "jog",
                "drive",
                "teleop",
                "teach",
                "run",
                "tasks",
                "stop",
                "pause",
                "resume",
            ),
            *("speed", "grasp", "release", "tool", "mount", "unmount", "kinematics"),
        ),
    ),
    Group(
        "Auxiliary figures",
        functions=(
            *("box", "capsule", "cone", "cylinder", "frame", "sphere", "table"),
            *("pose", "pose_from_quaternion", "quaternion_of", "roll_pitch_yaw_of"),
        ),
        python={"figure": "scene.figures:Figure"},
    ),
    Group(
        "View",
        services=("ViewService",),
        python={"client.view": "view.view:View"},
        commands=("view", "trace", "capture", "pixel", "measure", "walls"),
    ),
    Group(
        "Distance and collision",
        services=("CollisionService", "RayService"),
        batch=("SetCollisionSettings", "SetAllowedPairs"),
        python={"client.collisions": "collisions.collisions:Collisions", "client.rays": "sensors.rays:Rays"},
        commands=("collision", "rays", "avoid"),
    ),
    Group(
        "Physics",
        services=("PhysicsService",),
        batch=(
            "SetPhysics",
            "SetJointEfforts",
        ),
        python={"client.physics": "physics:Physics"},
        commands=("physics",),
    ),
    Group(
        "Sensors",
        services=("SensorService",),
        batch=("StartSensors", "StopSensors"),
        python={
            "client.sensors": "sensors.sensors:Sensors",
            "sensor": "sensors.sensors:Sensor",
            "client.streams": "streams.streams:Streams",
        },
        functions=(
            *("beams", "camera", "contact_sensor", "encoders", "fan", "force_torque_sensor", "imu", "light"),
            *("looking_at", "noise", "pose_sensor", "range_sensor", "raster", "ring", "spinning"),
        ),
        commands=("sensor", "map", "navigate", "marker", "register"),
    ),
    Group(
        "Time, signals, history and recordings",
        services=("SignalService", "HistoryService", "RecordService"),
        batch=("CreateSignal", "RemoveSignal", "SetSignal"),
        python={
            "client.signals": "signals:Signals",
            "client.records": "records:Records",
            "client.history": "history.history:History",
            "recording": "recording.recording:Recording",
        },
        client=("record", "redo", "start_recording", "undo"),
        commands=(
            "signal",
            "history",
            "undo",
            "redo",
            "checkpoint",
            "replay",
            "episode",
            "record",
            "topic",
            "lockstep",
            "fmu",
            "connections",
            "bridge",
            "ros",
        ),
    ),
    Group(
        "Real robots and plugins",
        services=("DriverService", "PluginService"),
        python={"client.cell": "cell:Cell", "client.drivers": "drivers:Drivers", "client.plugins": "plugins:Plugins"},
        commands=(
            *("driver", "estop", "emulate", "program", "rapid", "rapl", "urscript", "editor"),
            *("plugins", "grade", "study", "demo"),
        ),
    ),
)


def calls() -> dict[str, list[str]]:
    """Return the names of the calls of each service of the contract."""
    modules = (import_module(f"virtualrobot.v1.{file.stem}_pb2") for file in sorted(PROTO.glob("*.proto")))
    services = (service for module in modules for service in module.DESCRIPTOR.services_by_name.values())
    return {service.name: [method.name for method in service.methods] for service in services}


def batch_commands() -> dict[str, str]:
    """Return the commands of a batch, and the page of the reference on which each is."""
    (kinds,) = scene_pb2.Command.DESCRIPTOR.oneofs
    messages = [each.message_type for each in kinds.fields if each.message_type]
    return {message.name: f"reference/{Path(message.file.name).stem}.md" for message in messages}


def members(owner: type) -> Iterator[tuple[str, str]]:
    """Yield each public function or attribute of a class as it is written, and what it does."""
    for name in sorted(name for name in dir(owner) if not name.startswith("_")):
        value = inspect.getattr_static(owner, name)
        if callable(value) or isinstance(value, property | staticmethod | classmethod):
            yield name + ("" if isinstance(value, property) else "()"), summary(value)


def summary(value: Any) -> str:  # noqa: ANN401 anything that has a docstring
    """Return the first sentence of a docstring."""
    lines = (inspect.getdoc(value) or "").strip().split("\n\n")[0].split()
    return " ".join(lines).replace("|", "\\|")


def functions(module: ModuleType) -> list[str]:
    """Return the names of the functions that a program finds in `virtualrobot`."""
    return [name for name in dir(module) if inspect.isfunction(getattr(module, name)) and not name.startswith("_")]


def rows(group: Group) -> Iterator[tuple[str, str]]:
    """Yield the Python functions of a group, and what each does."""
    for name in group.functions:
        yield f"virtualrobot.{name}()", summary(getattr(virtualrobot, name))
    own = dict(members(virtualrobot.Client))
    for name in group.client:
        written = name if name in own else f"{name}()"
        yield f"client.{written}", own[written]
    for prefix, place in group.python.items():
        module, _, owner = place.partition(":")
        for written, does in members(getattr(import_module(f"virtualrobot.{module}"), owner)):
            yield f"{prefix}.{written}", does


def check_complete() -> None:
    """Raise ValueError for what has no group, and for what is in one and nowhere else."""
    shell = cli.cli.list_commands(click.Context(cli.cli))
    parts = re.findall(r"self\.(\w+) = \w+\(self\._services", inspect.getsource(virtualrobot.Client.__init__))
    prefixes = [prefix.removeprefix("client.") for group in GROUPS for prefix in group.python if "client." in prefix]
    for what, listed, there in (
        ("services of the contract", [name for group in GROUPS for name in group.services], list(calls())),
        ("commands of a batch", [name for group in GROUPS for name in group.batch], list(batch_commands())),
        ("functions of virtualrobot", [name for group in GROUPS for name in group.functions], functions(virtualrobot)),
        (
            "members of Client",
            [name for group in GROUPS for name in group.client],
            [written.removesuffix("()") for written, _ in members(virtualrobot.Client)],
        ),
        ("parts of Client", prefixes, parts),
        ("commands of the shell", [name for group in GROUPS for name in group.commands], list(shell)),
    ):
        missing, unknown = sorted(set(there) - set(listed)), sorted(set(listed) - set(there))
        if missing or unknown or len(listed) != len(set(listed)):
            raise ValueError(f"{what}: without a group are {missing}, there is no {unknown}, or one stands twice")


def page() -> str:
    """Return the page."""
    services, batch, parts, count = calls(), batch_commands(), [], 0
    files = {
        service: file.stem
        for file in PROTO.glob("*.proto")
        for service in services
        if f"service {service} " in file.read_text("utf-8")
    }
    for group in GROUPS:
        table = list(rows(group))
        count += len(table)
        lines = [f"## {group.title}", ""]
        for service in group.services:
            page = f"reference/{files[service]}.md"
            linked = ", ".join(f"[{call}]({page}#{call.lower()})" for call in services[service])
            lines.append(f"- [{service}]({page}): {linked}")
        if group.batch:
            linked = ", ".join(f"[{name}]({batch[name]}#{name.lower()})" for name in group.batch)
            lines.append(f"- in a batch of [Apply](reference/scene.md#apply): {linked}")
        if group.commands:
            lines.append(f"- in the shell: {', '.join(f'`virtualrobot {name}`' for name in group.commands)}")
        lines += ["", "| Python | what it does |", "|---|---|", *(f"| `{name}` | {does} |" for name, does in table)]
        parts.append("\n".join(lines))
    head = HEAD.format(
        python=count,
        calls=sum(map(len, services.values())),
        batch=len(batch),
        shell=sum(len(group.commands) for group in GROUPS),
    )
    return head + "\n" + "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    check_complete()
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
