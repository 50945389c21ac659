"""The file server that ROS# (Unity) takes URDF files from and sends them to: robots as they are, and a user's folder.

Source: siemens/ros-sharp, `UrdfTransferFromRos`, `UrdfTransferToRos`, and its ROS package `file_server2`: services
`/file_server/get_file` and `/file_server/save_file`, descriptions as parameters, meshes by `package://` names.
"""

from __future__ import annotations

import asyncio
import html
import re
import shutil
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path

import numpy as np
from virtualrobot import Client

from virtualrobot_apps.bridges.ros.hub import Hub, HubError, Service
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.mapping.names import topic_name
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.parameters import ParameterError

GET, SAVE = "file_server2/srv/GetBinaryFile", "file_server2/srv/SaveBinaryFile"
OWN = "virtualrobot"
"""Package of the robots' own files."""

ENDINGS = frozenset(
    (
        *(".urdf", ".xacro", ".stl", ".dae", ".obj", ".mtl", ".glb", ".gltf", ".bin", ".yaml", ".material"),
        *(".png", ".jpg", ".jpeg", ".bmp", ".tga", ".tif", ".tiff", ".gif"),
    )
)
"""Endings of files that are read and written: nothing else belongs to a robot."""

_URI = re.compile(r"package://([A-Za-z0-9_-]+)/([^\\:\0]+)")
_PARAMETER = re.compile(r"/(.+):robot_(description|name)")
_FILENAME = re.compile(r'filename="([^"]*)"')


class FileServer:
    """Robots of a world as URDF files with their meshes, and a folder where programs keep theirs."""

    def __init__(self, client: Client, own: Path, folder: Path | None = None) -> None:
        """Serve nothing yet; robots are written to the folder `own`, and without a `folder` nothing is kept."""
        self._client, self._own, self._folder = client, own, folder
        self._lock = threading.Lock()

    def serve(self, hub: Hub) -> None:
        """Add the services, and the parameters `/ROBOT:robot_description` and `/ROBOT:robot_name`."""
        hub.parameters.computed = self.parameter
        hub.serve(Service("/file_server/get_file", GET, _threaded(self._get)))
        hub.serve(Service("/file_server/save_file", SAVE, _threaded(self._save)))

    def parameter(self, name: str) -> Callable[[], str] | None:
        """Return what gives the value of a parameter, None where it is none of a robot's."""
        match = _PARAMETER.fullmatch(name)
        if match is None:
            return None
        wanted, what = match.groups()
        return lambda: self._description(self._robot(wanted)) if what == "description" else self._robot(wanted)

    def _robot(self, wanted: str) -> str:
        robots = list(self._client.robots)
        for robot in robots:
            if wanted == robot or f"/{wanted}" == topic_name(robot):
                return robot
        raise ParameterError(f"there is no robot {wanted[:80]!r}; known: {', '.join(robots) or 'none'}")

    def _description(self, robot: str) -> str:
        """Return the URDF of a robot as it is now; its meshes have names of the package `virtualrobot`."""
        name = topic_name(robot).removeprefix("/")
        with self._lock:
            folder = self._own / name
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            file = folder / "robot.urdf"
            self._client.scene.export(robot, file)
            text = file.read_text("utf-8")

        def named(match: re.Match[str]) -> str:
            path = html.unescape(match[1])
            uri = path if "://" in path else f"package://{OWN}/{name}/{path}"
            return f'filename="{html.escape(uri)}"'

        return _FILENAME.sub(named, text)

    def _path(self, name: str, *, saves: bool) -> Path:
        """Return where a file lies; raise HubError for what is no name of one, or lies elsewhere."""
        match = _URI.fullmatch(name)
        parts = match[2].split("/") if match else []
        if match is None or {"", ".", ".."} & set(parts):
            raise HubError(f"{name[:120]!r} is no name of a file: it is package://PACKAGE/FILE")
        if (ending := Path(parts[-1]).suffix.lower()) not in ENDINGS:
            raise HubError(f"files of robots end with {', '.join(sorted(ENDINGS))}, not {ending[:20]!r}")
        if match[1] == OWN:
            if saves:
                raise HubError(f"the package {OWN!r} has the robots of the world; save below another one")
            root, path = self._own, self._own.joinpath(*parts)
        elif self._folder is None:
            raise HubError(f"there is no package {match[1]!r}: the bridge was started without --files FOLDER")
        else:
            root, path = self._folder, self._folder.joinpath(match[1], *parts)
        if not path.resolve().is_relative_to(root.resolve()):
            raise HubError(f"{name[:120]!r} leads out of the folder of the files")
        return path

    def _get(self, asked: RosValue) -> RosValue:
        path = self._path(asked.name, saves=False)
        try:
            with self._lock:
                data = path.read_bytes()
        except OSError as error:
            raise HubError(f"{asked.name[:120]} cannot be read: {error.strerror or error}") from error
        return make(f"{GET}_Response", value=np.frombuffer(data, np.uint8))

    def _save(self, asked: RosValue) -> RosValue:
        path = self._path(asked.name, saves=True)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(np.asarray(asked.value, np.uint8).tobytes())
        except OSError as error:
            raise HubError(f"{asked.name[:120]} cannot be written: {error.strerror or error}") from error
        return make(f"{SAVE}_Response", name=asked.name)


def _threaded(work: Callable[[RosValue], RosValue]) -> Callable[[RosValue], Awaitable[RosValue]]:
    return lambda asked: asyncio.to_thread(work, asked)
