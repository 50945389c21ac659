"""A bridge that runs: a world on a hub, transports around it, until it is interrupted."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.bridges.ros.bridge_file import Choice
from virtualrobot_apps.bridges.ros.file_server import FileServer
from virtualrobot_apps.bridges.ros.hub import Hub
from virtualrobot_apps.bridges.ros.map_topic import MapTopic
from virtualrobot_apps.bridges.ros.rosbridge.rosapi import serve_rosapi
from virtualrobot_apps.bridges.ros.simuep.scene import SimuepScene
from virtualrobot_apps.bridges.ros.simuep.topics import SimuepTopics, lines_of
from virtualrobot_apps.bridges.ros.simulation.services import Simulation
from virtualrobot_apps.bridges.ros.transport import Transport
from virtualrobot_apps.bridges.ros.world import World

LOOK_SECONDS = 0.5
"""Time (s) after which what has come or gone in the world is seen, and a kernel that has gone is tried again."""


class RosBridge:
    """A bridge between a kernel and those who speak ROS; where the kernel has gone it waits for it.

    Example:
        >>> RosBridge(client, [RosbridgeServer()]).run()
    """

    def __init__(
        self,
        client: Client,
        transports: Sequence[Transport],
        choice: Choice | None = None,
        *,
        bare: bool = False,
        simuep: SimuepScene | None = None,
        files: Path | None = None,
        floor: Path | None = None,
        name: str = "the bridge",
        say: Callable[[str], None] = print,
    ) -> None:
        """Open nothing yet.

        Args:
            client: of the kernel.
            transports: what carries the topics.
            choice: which streams are which topics; all by default.
            bare: calls links as in the URDF, without their robot.
            simuep: a scene that names more topics and services.
            files: folder where programs keep files by the file server; without it they keep none.
            floor: map of a floor, a .yaml as map_server has it, which is told as `/map`; or OctoMap's .bt or .ot.
            name: tells it from other bridges of the kernel, whose worlds are kept apart for a reset.
            say: is told in words what happens.
        """
        self._client, self._transports, self._simuep, self._say = client, transports, simuep, say
        self._name = name
        self._choice, self._bare, self._files, self._floor = choice or Choice(), bare, files, floor

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Go on until it is interrupted, or `until` is true, which is asked twice a second.

        Raises:
            TransportError: when a transport can't be opened.
            MissingFileError, MalformedFileError: for a type that a stream doesn't give, and for a map that is none.
        """
        asyncio.run(self._run(until))

    def check(self) -> list[str]:
        """Return what there is now, a line for each topic; nothing is served. Raises as `run` does."""

        async def lines() -> list[str]:
            world = World(self._client, Hub(), self._choice, bare=self._bare, say=self._say)
            more = [*lines_of(self._simuep)] if self._simuep else []
            if self._floor is not None:
                told = MapTopic(Hub(), self._floor, self._say)
                more.append((told.name, told.type, f"of {self._floor}"))
            return await world.lines(more)

        return asyncio.run(lines())

    async def _run(self, until: Callable[[], bool]) -> None:
        with tempfile.TemporaryDirectory(prefix="virtualrobot-files-", ignore_cleanup_errors=True) as folder:
            await self._serve(until, FileServer(self._client, Path(folder), self._files))

    async def _serve(self, until: Callable[[], bool], files: FileServer) -> None:
        hub = Hub()
        serve_rosapi(hub)
        files.serve(hub)
        world = World(self._client, hub, self._choice, bare=self._bare, say=self._say)
        await world.update()
        floor = None if self._floor is None else MapTopic(hub, self._floor, self._say)
        if self._simuep is not None:
            SimuepTopics(self._client, hub, self._simuep, self._say).serve()
        simulation = Simulation(self._client, hub, bare=self._bare, name=self._name)
        if serves := await self._kept(simulation):
            simulation.serve()
        opened: list[Transport] = []
        try:
            for one in self._transports:
                self._say(await one.open(hub))
                opened.append(one)
            gone = False
            while not until():
                await asyncio.sleep(LOOK_SECONDS)
                if floor is not None:
                    floor.update()
                try:
                    await world.update()
                    if gone:
                        self._say("the kernel is back")
                        serves = serves and await self._kept(simulation)
                    gone = False
                except ConnectionError as error:
                    if not gone:
                        self._say(f"{error}; it is tried again each {LOOK_SECONDS:g} s")
                        world.close()
                    gone = True
        finally:
            world.close()
            for one in opened:
                await one.close()
            await simulation.close()

    async def _kept(self, simulation: Simulation) -> bool:
        """Return whether the world could be kept as it is, to which a reset goes back; else it is said why not."""
        try:
            await simulation.keep()
        except VirtualRobotError as error:
            self._say(f"services of simulation_interfaces are left out: {error}")
            return False
        return True
