"""Imports go in one direction: each room sees the packages that its rule names, and no other.

The rules are the table below. A file obeys the rule with the longest path that contains it; the standard library is
open to all. Imports inside functions, under TYPE_CHECKING and by `import_module("...")` count too.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CLIENT = "clients/python/virtualrobot"
APPS = "clients/python/virtualrobot_apps"
KERNEL = "kernel/virtualrobot_kernel"
SDK = "plugins/virtualrobot_sdk"
PLUGINS = "plugins/virtualrobot_plugins"

# Files beside the rooms, and arrays and poses, which plugins need, too.
ANYONE = (
    *("numpy", "virtualrobot_sdk.arrays", "virtualrobot_sdk.poses"),
    *("virtualrobot_kernel.errors", "virtualrobot_kernel.background", "virtualrobot_kernel.lateness"),
    *("virtualrobot_kernel.units", "virtualrobot_kernel.version", "virtualrobot_kernel.whole_files"),
)
CONTRACT = ("google.protobuf", "virtualrobot.v1")
# What `serve` takes from the client: where tokens are, and the console, which is a process of its own.
CALLED = ("virtualrobot.session", "virtualrobot.console_process")

# Which rooms of the kernel each of its rooms may see: a room stands above all that it names.
ROOMS: dict[str, tuple[str, ...]] = {
    "numeric": (),
    "components": (),
    "motion": ("numeric",),
    "world": ("motion",),
    "inputs": ("world",),
    "history": ("motion", "world"),
    "shapes": ("world",),
    "messages": ("motion", "world"),
    "planning": ("components", "motion", "numeric", "world"),
    "formats": ("messages", "numeric", "shapes", "world"),
    "scenes": ("formats", "messages", "world"),
    "collision": ("motion", "numeric", "planning", "shapes", "world"),
    "paths": ("collision", "motion", "numeric", "planning", "world"),
    "crafts": ("components", "motion", "planning", "world"),
    "drivers": ("components", "inputs", "motion", "numeric", "world"),
    "physics": ("collision", "components", "numeric", "shapes", "world"),
    "sensing": ("collision", "components", "numeric", "planning", "shapes", "world"),
    "drawing": ("collision", "numeric", "planning", "sensing", "shapes", "world"),
    "api": (
        *(
            "collision",
            "components",
            "crafts",
            "drawing",
            "drivers",
            "formats",
            "history",
            "inputs",
            "messages",
            "motion",
            "paths",
            "physics",
            "planning",
        ),
        *("scenes", "sensing", "world"),
    ),
}


def room(name: str, *others: str) -> tuple[str, ...]:
    """Return what a room of the kernel may import: itself, the rooms of its rule, and `others`."""
    return (*ANYONE, *(f"virtualrobot_kernel.{one}" for one in (name, *ROOMS[name])), *others)


# What is pure has no native library, no gRPC and no protobuf. What plans motions sees the interface of kinematics, and
# none of its solvers.
MOTION = (*ANYONE, "virtualrobot_kernel.motion", "virtualrobot_sdk.kinematics")

MAY_IMPORT: dict[str, tuple[str, ...]] = {
    # The client knows nothing of the kernel; an application knows only the client library.
    CLIENT: ("virtualrobot", "numpy", "grpc", "grpc_status", "google", "click", "platformdirs", "prompt_toolkit"),
    APPS: ("virtualrobot_apps", "virtualrobot", "numpy", "click"),
    # What users get to begin with: a test beside a program.
    f"{APPS}/new/cells": ("virtualrobot", "numpy", "pytest", "program"),
    # Messages of a foreign protocol, made from a table.
    f"{APPS}/emulators/egm": ("virtualrobot_apps.emulators", "virtualrobot", "numpy", "click", "google.protobuf"),
    # The emulated ABB controller serves HTTP.
    f"{APPS}/emulators/abb/server.py": ("virtualrobot_apps", "virtualrobot", "uvicorn"),
    # So is a plugin, which its author goes on with.
    f"{APPS}/new/drivers": ("virtualrobot_sdk", "numpy", "serial", "pytest", "board"),
    # Programs of other people, who know nothing of us, and the hand that starts them.
    f"{APPS}/demos/controllers": ("virtualrobot_apps", "virtualrobot", "click", "abb_robot_client", "dashboard_client"),
    f"{APPS}/demos/controllers/programs": ("abb_robot_client", "rtde_control", "rtde_receive"),
    # The mapping application grows its octree by OctoMap; clients that don't map need not have it.
    f"{APPS}/demos/mapping/octree_map.py": ("virtualrobot", "numpy", "pyoctomap"),
    # Navigation fits, measures distances and plans by libraries, where they are installed, and writes maps as ROS does.
    f"{APPS}/seeing": ("virtualrobot_apps", "virtualrobot", "numpy", "scipy"),
    f"{APPS}/seeing/changes/registering.py": ("virtualrobot_apps", "virtualrobot", "numpy", "scipy", "small_gicp"),
    f"{APPS}/seeing/navigation": ("virtualrobot_apps", "virtualrobot", "numpy", "click", "scipy", "pyastar2d", "yaml"),
    # Processes look for ways on meshes, and on splines.
    f"{APPS}/demos/processes": ("virtualrobot_apps", "virtualrobot", "numpy", "click", "trimesh"),
    f"{APPS}/processes": ("virtualrobot_apps", "virtualrobot", "numpy", "click", "scipy", "trimesh"),
    # Films and chips are compiled, and shadows are traced by the ray engine.
    **{
        f"{APPS}/processes/effects/{name}.py": ("virtualrobot_apps", "virtualrobot", "virtualrobot_sdk", *libraries)
        for name, libraries in {
            "film": ("numpy", "trimesh"),
            "spraying": ("numpy", "numba"),
            "cutting": ("numpy", "numba"),
        }.items()
    },
    # Studies run in processes of loky, draw by scipy, search by cma and leave Parquet files, in buckets by obstore,
    # where these are installed.
    **{
        f"{APPS}/studies/{name}.py": ("virtualrobot_apps", "virtualrobot", "numpy", *libraries)
        for name, libraries in {
            "best": ("pyarrow", "yaml"),
            "engines": ("loky",),
            "environment": ("gymnasium",),
            "parameters": ("scipy",),
            "parts": ("pyarrow",),
            "ray_engine": ("ray", "grpc"),
            "report": ("pyarrow",),
            "searching": ("cma", "optuna"),
            "stores": ("obstore",),
            "report_charts": ("pyarrow",),
            "summary": ("pyarrow", "scipy"),
        }.items()
    },
    # Programs for controllers are read from, and written as, program files in the contract's words.
    f"{APPS}/languages/writers": ("virtualrobot_apps", "virtualrobot", "numpy", "click", "yaml", "google.protobuf"),
    # Curves of IGES and STEP are read by Open CASCADE, where it is installed.
    f"{APPS}/curves/opencascade.py": ("OCP",),
    # Each bridge speaks by the library of its protocol, where that is installed.
    f"{APPS}/bridges/modbus.py": ("virtualrobot_apps", "virtualrobot", "pymodbus"),
    f"{APPS}/bridges/mqtt.py": ("virtualrobot_apps", "virtualrobot", "paho"),
    f"{APPS}/bridges/opcua.py": ("virtualrobot_apps", "virtualrobot", "asyncua"),
    # The bridge to ROS: types and bytes by rosbags, pictures by Pillow, and each transport by its own library.
    **{
        f"{APPS}/bridges/ros/{name}": ("virtualrobot_apps", "virtualrobot", "numpy", *libraries)
        for name, libraries in {
            "bag.py": ("rosbags", "click"),
            "recorder.py": ("rosbags",),
            "player.py": ("rosbags",),
            "messages/types.py": ("rosbags", "yaml"),
            "messages/ros1.py": ("rosbags",),
            "mapping/sensors.py": ("PIL",),
            "dds": ("cyclonedds",),
            "rclpy_node.py": ("rclpy",),
            "zenoh_node.py": ("zenoh",),
            "foxglove_server.py": ("foxglove",),
            # A robot of ROS is driven from here, so that no plugin needs to know of ROS.
            "driver.py": ("virtualrobot_sdk", "msgspec", "websockets"),
            "rosbridge/wire.py": ("cbor2", "PIL"),
            "rosbridge/client.py": ("websockets",),
            "rosbridge/server.py": ("websockets",),
            "rosbridge/connections.py": ("websockets",),
        }.items()
    },
    # FMUs are loaded by FMPy and made by PythonFMU3, where they are installed; one that controls is a program.
    f"{APPS}/fmi/wire.py": ("virtualrobot_apps.fmi", "virtualrobot_apps.lockstep", "virtualrobot"),
    f"{APPS}/fmi/controller.py": ("virtualrobot_apps.fmi", "virtualrobot", "fmpy"),
    f"{APPS}/fmi/export.py": ("virtualrobot_apps.fmi", "virtualrobot", "pythonfmu3"),
    f"{APPS}/fmi/slave.py": ("virtualrobot_apps.fmi", "virtualrobot", "pythonfmu3"),
    # The console passes calls of any method on, in bytes: it speaks gRPC and the contract itself, and serves HTTP.
    f"{APPS}/console/plots.py": ("virtualrobot_apps.console", "virtualrobot_apps.topic", "virtualrobot"),
    f"{APPS}/console": ("virtualrobot_apps.console", "virtualrobot", "google", "grpc"),
    f"{APPS}/console/command.py": ("virtualrobot_apps.console", "virtualrobot", "click"),
    # For its pages it runs what another command runs, too.
    f"{APPS}/console/wiring.py": ("virtualrobot_apps", "virtualrobot"),
    f"{APPS}/console/registering.py": ("virtualrobot_apps", "virtualrobot", "numpy"),
    f"{APPS}/console/processing.py": ("virtualrobot_apps", "virtualrobot", "numpy"),
    f"{APPS}/console/invitation.py": ("virtualrobot_apps.console", "virtualrobot", "segno"),
    f"{APPS}/episodes/episode.py": ("virtualrobot", "numpy", "mcap", "foxglove_schemas_protobuf", "PIL"),
    f"{APPS}/episodes/dataset.py": ("virtualrobot_apps.episodes", "virtualrobot", "numpy", "pyarrow"),
    f"{APPS}/console/serving.py": ("virtualrobot_apps.console", "virtualrobot_apps.asgi", "virtualrobot", "uvicorn"),
    f"{APPS}/console/authority.py": ("virtualrobot", "cryptography", "platformdirs"),
    f"{APPS}/asgi.py": ("uvicorn",),
    # Recorded files are read by the libraries of their formats, and PNGs drawn by Pillow, where these are installed.
    f"{APPS}/topic/recorded.py": (
        "virtualrobot_apps",
        "virtualrobot",
        "numpy",
        "mcap",
        "pyarrow",
        "foxglove_schemas_protobuf",
        "google",
    ),
    f"{APPS}/topic/raster.py": ("virtualrobot_apps", "virtualrobot", "numpy", "PIL"),
    # What they say is read from YAML.
    f"{APPS}/vehicles/vehicle_file.py": ("virtualrobot", "numpy", "yaml"),
    f"{APPS}/cell_io/yaml_file.py": ("virtualrobot", "yaml"),
    f"{APPS}/cell_io/yaml_text.py": ("virtualrobot_apps", "yaml"),
    # The Boe-Bot's worlds are written as YAML, and its pictures looked at by OpenCV, where that is installed.
    f"{APPS}/vehicles/boebot/worlds.py": ("virtualrobot_apps", "numpy", "yaml"),
    f"{APPS}/vehicles/boebot/line_follower.py": ("virtualrobot", "numpy", "cv2"),
    # So are printed markers.
    f"{APPS}/registration/marker_pose.py": ("virtualrobot_apps", "virtualrobot", "numpy", "cv2"),
    # Films are written by FFmpeg, where its package is installed.
    f"{CLIENT}/view/film.py": ("virtualrobot", "numpy", "av"),
    # Fixtures, which pytest finds.
    f"{CLIENT}/testing.py": ("virtualrobot", "pytest"),
    # Serial ports are listed by pyserial, where it is installed.
    f"{CLIENT}/cli/ports.py": ("virtualrobot", "click", "serial"),
    # Gamepads are read by SDL, where it is installed; what they mean is written in YAML.
    f"{CLIENT}/cli/gamepad.py": ("virtualrobot", "sdl2"),
    f"{CLIENT}/cli/gamepad_mapping.py": ("virtualrobot", "yaml"),
    f"{CLIENT}/cli/space_mouse.py": ("virtualrobot", "hid"),
    # Recordings are written by the libraries of their formats, where these are installed.
    f"{CLIENT}/recording": ("virtualrobot", "numpy", "google"),
    f"{CLIENT}/recording/mcap_file.py": ("virtualrobot", "google", "mcap"),
    f"{CLIENT}/recording/parquet_file.py": ("virtualrobot", "pyarrow"),
    **{
        f"{CLIENT}/recording/{name}.py": ("virtualrobot", "numpy", "google", "foxglove_schemas_protobuf")
        for name in ("entities", "mcap_output", "readings", "scenery", "transforms")
    },
    # The composition root knows every room; `serve` writes the token where the client's rule says, starts the console.
    KERNEL: (*ANYONE, "virtualrobot_kernel", "virtualrobot_sdk.worker"),
    f"{KERNEL}/compiling.py": (*ANYONE, "virtualrobot_kernel.numeric", "virtualrobot_sdk.compiled.cache"),
    f"{KERNEL}/serve.py": (*ANYONE, "virtualrobot_kernel", "virtualrobot_sdk.compiled.cache", *CALLED),
    f"{KERNEL}/world": room("world"),
    f"{KERNEL}/inputs": room("inputs"),
    # Documents are MessagePack.
    f"{KERNEL}/history": room("history", "msgspec"),
    f"{KERNEL}/numeric": room("numeric", "numba", "virtualrobot_sdk.compiled"),
    # ruckig and toppra make the time laws of what is planned, and ruckig in the tick the next step of what follows
    # setpoints, which nobody can plan: a pure function of a few microseconds.
    f"{KERNEL}/motion": MOTION,
    f"{KERNEL}/motion/profile.py": (*MOTION, "ruckig"),
    f"{KERNEL}/motion/time_optimal.py": (*MOTION, "virtualrobot_kernel.numeric.laws", "toppra"),
    f"{KERNEL}/motion/online.py": (*MOTION, "ruckig"),
    # In the tick an arm goes along with a frame by compiled Newton steps.
    **{
        f"{KERNEL}/motion/{name}.py": (*MOTION, "virtualrobot_kernel.numeric.following")
        for name in ("resolved_rate", "tool_lead")
    },
    f"{KERNEL}/motion/path.py": (*MOTION, "virtualrobot_kernel.numeric.tridiagonal"),
    f"{KERNEL}/motion/conveyor_tracking.py": (*MOTION, "virtualrobot_kernel.numeric.tracking"),
    # Laws are searched, and what moves by them is looked at, at thousands of places.
    **{f"{KERNEL}/motion/{name}.py": (*MOTION, "virtualrobot_kernel.numeric.laws") for name in ("path_law", "rates")},
    # In a tick all motions on plans are sampled at once.
    f"{KERNEL}/motion/planned.py": (*MOTION, "virtualrobot_kernel.numeric.laws", "virtualrobot_kernel.numeric.samples"),
    # Of the many brakes that are tried, the one that keeps the limits is chosen within a tick.
    f"{KERNEL}/motion/brake.py": (
        *MOTION,
        *(f"virtualrobot_kernel.numeric.{one}" for one in ("braking", "memory", "rings")),
    ),
    # Plugins are found by entry point; no room imports one.
    f"{KERNEL}/components": room("components", "virtualrobot_sdk"),
    f"{KERNEL}/components/remembered.py": room("components", "virtualrobot_sdk", "msgspec"),
    f"{KERNEL}/planning": room("planning", "virtualrobot_sdk"),
    f"{KERNEL}/crafts": room("crafts", "virtualrobot_sdk"),
    f"{KERNEL}/shapes": room("shapes", "virtualrobot_sdk.rays"),
    f"{KERNEL}/shapes/textures.py": room("shapes", "PIL"),
    f"{KERNEL}/messages": room("messages", *CONTRACT, "virtualrobot_sdk.denavit_hartenberg"),
    # The resolver is path logic that both ends share.
    f"{KERNEL}/formats": room(
        *("formats", "virtualrobot_sdk", "virtualrobot.files.resolver", *CONTRACT),
        *("trimesh", "lxml", "yaml", "collada", "PIL"),
    ),
    # Parsed meshes lie in the user's cache.
    f"{KERNEL}/formats/mesh_cache.py": room("formats", "msgspec", "platformdirs"),
    f"{KERNEL}/formats/picture_cache.py": room("formats", "platformdirs", "virtualrobot_sdk"),
    # Most OBJ files are read in one compiled pass.
    f"{KERNEL}/formats/obj.py": room("formats", "trimesh", "virtualrobot_kernel.numeric.wavefront"),
    f"{KERNEL}/scenes": room("scenes", "virtualrobot.files.resolver", "virtualrobot.v1"),
    # FCL holds the interpreter's lock: whoever asks it goes through the bounded calls of this room.
    f"{KERNEL}/collision": room("collision", "fcl", "virtualrobot_sdk"),
    # OMPL holds the interpreter's lock: it runs in a process of its own, and only this file imports it.
    f"{KERNEL}/paths": room("paths", "virtualrobot_sdk"),
    f"{KERNEL}/paths/search.py": room("paths", "ompl"),
    f"{KERNEL}/sensing": room("sensing", "virtualrobot_sdk"),
    f"{KERNEL}/drivers": room("drivers", "virtualrobot_sdk"),
    f"{KERNEL}/physics": room("physics", "virtualrobot_sdk"),
    # The browser by viser, whose server is that of websockets; files of pictures, and the letters in them, by Pillow.
    f"{KERNEL}/drawing": room("drawing", "virtualrobot_sdk", "viser", "websockets", "PIL"),
    f"{KERNEL}/api": room(
        *("api", *CONTRACT, "grpc", "grpc_status", "grpc_health", "grpc_reflection", "google.rpc"),
        "virtualrobot_sdk",
    ),
    # What plugin authors import knows neither kernel nor client, and plugins know only it.
    SDK: ("virtualrobot_sdk", "numpy", "pluggy", "msgspec", "psutil"),
    f"{SDK}/compiled": ("virtualrobot_sdk", "numpy", "numba", "llvmlite", "platformdirs"),
    # Embree is driven through ctypes, its packets filled and read by compiled code, which calls it by address.
    f"{SDK}/embree": ("virtualrobot_sdk", "numpy", "numba", "llvmlite"),
    f"{SDK}/xml.py": ("lxml",),
    f"{SDK}/testing": ("virtualrobot_sdk", "numpy", "click", "psutil", "pytest"),
    PLUGINS: ("virtualrobot_plugins", "virtualrobot_sdk", "numpy"),
    f"{PLUGINS}/arm_angle": (
        *("virtualrobot_plugins.arm_angle", "virtualrobot_plugins.closed_form", "virtualrobot_plugins.chain"),
        *("virtualrobot_sdk", "numpy", "numba"),
    ),
    f"{PLUGINS}/chain": ("virtualrobot_plugins.chain", "virtualrobot_sdk", "numpy", "numba"),
    # EAIK has the closed forms; what they give is polished by the numeric solver.
    f"{PLUGINS}/closed_form": (
        *("virtualrobot_plugins.closed_form", "virtualrobot_plugins.chain", "virtualrobot_sdk", "numpy", "numba"),
        "eaik",
    ),
    # Vehicles are files of parameters.
    f"{PLUGINS}/marine": (*("virtualrobot_plugins.marine", "virtualrobot_sdk", "numpy", "numba", "msgspec", "yaml"),),
    # Settings are described by msgspec's Meta.
    f"{PLUGINS}/mobile": ("virtualrobot_plugins.mobile", "virtualrobot_sdk", "numpy", "msgspec"),
    f"{PLUGINS}/sensor_models": ("virtualrobot_plugins.sensor_models", "virtualrobot_sdk", "numpy", "msgspec"),
    f"{PLUGINS}/sensor_models/laser_readings.py": ("virtualrobot_sdk", "numpy", "numba"),
    # Models by name are data: tables in YAML.
    f"{PLUGINS}/models": ("virtualrobot_plugins.models", "virtualrobot_sdk", "numpy", "msgspec", "yaml"),
    # Physics engines see their own library each.
    f"{PLUGINS}/physics": ("virtualrobot_plugins.physics", "virtualrobot_sdk", "numpy", "msgspec"),
    f"{PLUGINS}/physics/bullet": ("virtualrobot_plugins.physics", "virtualrobot_sdk", "numpy", "msgspec", "pybullet"),
    f"{PLUGINS}/physics/mujoco": ("virtualrobot_plugins.physics", "virtualrobot_sdk", "numpy", "msgspec", "mujoco"),
    # embreex casts rays where its library can't be driven.
    f"{PLUGINS}/ray_casters/embreex_scene.py": ("virtualrobot_sdk", "numpy", "embreex"),
    # Bullet is there to compare with; its worker process alone loads it.
    f"{PLUGINS}/ray_casters/bullet.py": ("virtualrobot_sdk", "numpy", "pybullet"),
    # Drivers are found by name; each sees what its protocol needs.
    f"{PLUGINS}/drivers": ("virtualrobot_plugins.drivers", "virtualrobot_sdk", "numpy", "msgspec"),
    f"{PLUGINS}/drivers/loopback": ("virtualrobot_plugins.drivers.loopback", "virtualrobot_sdk", "numpy", "msgspec"),
    f"{PLUGINS}/drivers/dynamixel/bus.py": ("virtualrobot_plugins.drivers", "virtualrobot_sdk", "dynamixel_sdk"),
    f"{PLUGINS}/drivers/serial_port.py": ("virtualrobot_sdk", "serial"),
    f"{PLUGINS}/importers": (
        *("virtualrobot_plugins.importers", "virtualrobot_sdk", "numpy"),
        *("cascadio", "ezdxf", "lxml", "manifold3d", "msgspec", "PIL", "trimesh", "xacro", "yaml"),
    ),
}


# Files beside the rooms.
FILES = frozenset({"compiling.py", "embedded.py", "kernel.py", "serve.py"})


def imports(source: str, package: str) -> Iterator[tuple[int, str]]:
    """Yield line and absolute dotted name of everything that `source`, a module of `package`, imports.

    `from a import b` yields "a.b", since b may be a module.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*parents, *([node.module] if node.module else [])])
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            function = ast.unparse(node.func)
            if function in ("__import__", "import_module", "importlib.import_module"):
                yield node.lineno, str(node.args[0].value)


def rule_of(path: str) -> str:
    """Return the longest path of the table that contains `path`."""
    return max((rule for rule in MAY_IMPORT if path == rule or path.startswith(f"{rule}/")), key=len)


def violations(root: Path) -> list[str]:
    """Return "path:line imports name; rule" for each import below `root` that its rule doesn't name."""
    found = []
    for base in (KERNEL, CLIENT, APPS, SDK, PLUGINS):
        for file in sorted((root / base).rglob("*.py")):
            path = file.relative_to(root).as_posix()
            package = ".".join(file.parent.relative_to((root / base).parent).parts)
            allowed = MAY_IMPORT[rule_of(path)]
            for line, name in imports(file.read_text(), package):
                standard = name.partition(".")[0] in sys.stdlib_module_names
                if not standard and not any(name == module or name.startswith(f"{module}.") for module in allowed):
                    found.append(f"{path}:{line} imports {name}; {rule_of(path)} may import {', '.join(allowed)}")
    return found


def test_every_import_obeys_its_rule() -> None:
    assert not violations(ROOT), "\n".join(violations(ROOT))


def test_every_room_of_the_kernel_has_a_rule() -> None:
    folders = {path.parent.name for path in (ROOT / KERNEL).glob("*/*.py")}
    assert folders == set(ROOMS) == {rule.split("/")[2] for rule in MAY_IMPORT if rule.startswith(f"{KERNEL}/")} - FILES


def test_no_circle_of_rooms() -> None:
    """Rooms are taken away from below, each when all that it may see has gone; a circle would remain."""
    remaining = dict(ROOMS)
    while ground := [name for name, seen in remaining.items() if not set(seen) & set(remaining)]:
        for name in ground:
            del remaining[name]
    assert not remaining


def test_no_room_may_see_what_it_does_not_use() -> None:
    """An arrow that is gone goes from the table, too, so that the table tells what is."""
    used = {name: set() for name in ROOMS}
    for name in ROOMS:
        for file in (ROOT / KERNEL / name).rglob("*.py"):
            package = ".".join(file.parent.relative_to((ROOT / KERNEL).parent).parts)
            names = (seen.split(".") for _, seen in imports(file.read_text(), package))
            used[name] |= {parts[1] for parts in names if parts[0] == "virtualrobot_kernel"} & set(ROOMS)
    assert {name: tuple(sorted(seen - {name})) for name, seen in used.items()} == ROOMS


def test_every_rule_is_about_something() -> None:
    """A room that was renamed would otherwise fall to a weaker rule unseen."""
    assert [rule for rule in MAY_IMPORT if not (ROOT / rule).exists()] == []


@pytest.mark.parametrize(
    ("path", "source", "name"),
    [
        (f"{CLIENT}/robots/robot.py", "import virtualrobot_kernel", "virtualrobot_kernel"),
        (f"{CLIENT}/cli/serve.py", "def f():\n    from virtualrobot_kernel import serve", "virtualrobot_kernel.serve"),
        (f"{CLIENT}/cli/serve.py", "import_module('virtualrobot_kernel.serve')", "virtualrobot_kernel.serve"),
        (f"{CLIENT}/robots/robot.py", "import scipy.spatial", "scipy.spatial"),
        (f"{CLIENT}/robots/robot.py", "from virtualrobot_apps import demos", "virtualrobot_apps.demos"),
        (f"{APPS}/demos/viewer.py", "import grpc", "grpc"),
        (f"{KERNEL}/world/state.py", "import numba", "numba"),
        (f"{KERNEL}/world/state.py", "from ..drawing import viewer", "virtualrobot_kernel.drawing.viewer"),
        (f"{KERNEL}/world/state.py", "from .. import api", "virtualrobot_kernel.api"),
        (f"{KERNEL}/world/state.py", "import ruckig", "ruckig"),
        (f"{KERNEL}/world/commands.py", "from virtualrobot.v1 import scene_pb2", "virtualrobot.v1.scene_pb2"),
        (f"{KERNEL}/motion/linear.py", "from ruckig import Ruckig", "ruckig.Ruckig"),
        (f"{KERNEL}/motion/linear.py", "import numpy, numba", "numba"),
        (f"{KERNEL}/motion/plan.py", "import virtualrobot_sdk.worker", "virtualrobot_sdk.worker"),
        (f"{KERNEL}/planning/solvers.py", "import virtualrobot_plugins", "virtualrobot_plugins"),
        (f"{SDK}/kinematics.py", "from virtualrobot_kernel import errors", "virtualrobot_kernel.errors"),
        (f"{SDK}/worker/parent.py", "import numba", "numba"),
        (f"{PLUGINS}/chain/component.py", "from virtualrobot_plugins import dh", "virtualrobot_plugins.dh"),
        (f"{PLUGINS}/dh.py", "import virtualrobot", "virtualrobot"),
        (f"{KERNEL}/kernel.py", "import grpc", "grpc"),
        (f"{KERNEL}/kernel.py", "if TYPE_CHECKING:\n    import viser", "viser"),
        (f"{KERNEL}/formats/scene.py", "import virtualrobot", "virtualrobot"),
        (f"{KERNEL}/formats/scene.py", "from virtualrobot import connect", "virtualrobot.connect"),
        (f"{KERNEL}/drawing/viewer.py", "import trimesh", "trimesh"),
        (f"{KERNEL}/sensing/contact_reader.py", "import fcl", "fcl"),
        (f"{KERNEL}/api/server.py", "import numba", "numba"),
        (f"{KERNEL}/anew/room.py", "import pybullet", "pybullet"),
        (f"{KERNEL}/formats/urdf_sensors.py", "from ..api import server", "virtualrobot_kernel.api.server"),
        (f"{KERNEL}/sensing/picture.py", "from ..drawing import view", "virtualrobot_kernel.drawing.view"),
        (f"{KERNEL}/collision/site.py", "from ..sensing import appearance", "virtualrobot_kernel.sensing.appearance"),
        (f"{KERNEL}/motion/follow.py", "from ..numeric import forest", "virtualrobot_kernel.numeric.forest"),
    ],
)
def test_a_planted_violation_is_found(tmp_path: Path, path: str, source: str, name: str) -> None:
    (tmp_path / path).parent.mkdir(parents=True)
    (tmp_path / path).write_text(source)
    (found,) = violations(tmp_path)
    assert f"imports {name};" in found
    assert found.startswith(f"{path}:{len(source.splitlines())} ")


@pytest.mark.parametrize(
    ("path", "source"),
    [
        (f"{APPS}/demos/viewer.py", "import virtualrobot, numpy.linalg, click, json"),
        (f"{KERNEL}/motion/profile.py", "from ruckig import Ruckig\nfrom ..errors import LimitError\nimport numpy"),
        (f"{KERNEL}/world/state.py", "from . import structure\nfrom ..motion.path import Path\nimport threading"),
        (f"{KERNEL}/api/server.py", "import grpc.aio\nfrom google.rpc import code_pb2\nfrom ..world import store"),
        (f"{KERNEL}/formats/scene.py", "from virtualrobot.v1 import scene_pb2\nimport virtualrobot.files.resolver"),
    ],
)
def test_what_the_rules_name_passes(tmp_path: Path, path: str, source: str) -> None:
    (tmp_path / path).parent.mkdir(parents=True)
    (tmp_path / path).write_text(source)
    assert violations(tmp_path) == []
