"""Programs of other people work one cell, and a box stops one robot: `virtualrobot demo controllers`.

The programs, in `programs/`, know nothing of virtualrobot: they get addresses of controllers, as those of real ones.
"""

from __future__ import annotations

import functools
import queue
import socket
import subprocess
import sys
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import virtualrobot
from abb_robot_client.rws import RWS
from dashboard_client import DashboardClient
from virtualrobot import Client, pose
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.demos.twin.controllers import Controller, universal_robots
from virtualrobot_apps.demos.viewer import show_viewer

PROGRAMS = Path(__file__).parent / "programs"
PORT = 5000
"""Port that the program of the turner has in its text."""
BOX_SIZE, BOX_PLACE = (0.06, 0.06, 0.9), (0.34, 1.33, 0.45)
"""Of a box on the turner's way from 0 to 30 degrees, meters."""
EXECUTION_ERROR = 10020
"""Code of a message in an ABB controller's log: a program can't go on."""


def main(client: Client, options: Sequence[str] = (), headless: bool = False) -> None:
    """Build the cell, start the controllers, and let the programs work, without and with a box in the way.

    `options` are those by which a command knows the kernel, besides its address.
    """
    load(client)
    show_viewer(client, headless)
    here = ["--address", client.address, *options]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="virtualrobot-controllers-")))
        port = _free_port()
        module = folder / "turner.mod"
        text = (PROGRAMS / "turner.mod").read_text("utf-8")
        module.write_text(text.replace(f"PORT := {PORT}", f"PORT := {port}"), "utf-8")
        feeder = stack.enter_context(Controller(["abb", "feeder", "--port", "0", *here], "at http")).place
        listens = ["--module", str(module), "--listen"]
        turner = stack.enter_context(Controller(["abb", "turner", "--port", "0", *listens, *here], "at http")).place
        ur, host = universal_robots(options=["packer", *here], hear=functools.partial(_show, "packer's controller"))
        stack.enter_context(ur)
        print(f"controllers: feeder, ABB at {feeder}; turner, ABB at {turner}; packer, UR at {host}", flush=True)
        arguments = {"feeder": [feeder], "turner": ["127.0.0.1", str(port)], "packer": [host, feeder]}
        start(turner)
        work(arguments)
        client.scene.add_part("box", virtualrobot.box(*BOX_SIZE), pose=pose(*BOX_PLACE))
        print("a box is put in the way of the turner", flush=True)
        work(arguments)
        for name, url in {"turner": turner, "feeder": feeder}.items():
            print(f"the log of the {name}'s controller has {' and '.join(errors(url)) or 'no error'}", flush=True)
        print(f"the packer's controller says: {safety(host)}", flush=True)


def load(client: Client) -> None:
    """Replace the world by the cell; its robots are guarded."""
    client.scene.clear()
    client.load_robot("model://irb120", name="feeder")
    client.load_robot("model://irb120", name="turner", pose=pose(y=1.2))
    client.load_robot("model://ur5e", name="packer", pose=pose(x=1.1, yaw=3.14))
    client.robot("packer").set_positions([0.8, -1.57, 1.57, -1.57, -1.57, 0.0])
    client.signals.create("doPart")
    client.signals.create("diTaken")
    client.collisions.set(robots={name: "guard" for name in ("feeder", "turner", "packer")})


def start(url: str) -> None:
    """Start the program of an ABB controller, as somebody does on its pendant."""
    robot = RWS(url)
    robot.resetpp()
    robot.start(cycle="once")


def errors(url: str) -> list[str]:
    """Return why programs could not go on, by the log of an ABB controller, the oldest first."""
    return [str(one.args[0]) for one in reversed(RWS(url).read_event_log()) if one.code == EXECUTION_ERROR]


def safety(host: str) -> str:
    """Return what the safety system of a controller of Universal Robots says, by its dashboard server."""
    dashboard = DashboardClient(host)
    dashboard.connect()
    try:
        return dashboard.safetystatus()
    finally:
        dashboard.disconnect()


def work(arguments: Mapping[str, Iterable[str]]) -> None:
    """Run the programs side by side, by name, with what each is told; show what they print until all have ended.

    Raises:
        WrongStateError: when one fails: the others, which may wait for it for ever, are ended.
    """
    with ExitStack() as stack:
        ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        running: dict[str, subprocess.Popen[str]] = {}
        for name, words in arguments.items():
            command = [sys.executable, "-u", str(PROGRAMS / f"{name}.py"), *words]
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            running[name] = stack.enter_context(process)
            stack.callback(process.kill)
            threading.Thread(target=_show_all, args=(name, process, ended), name=f"words of {name}").start()
        for _ in arguments:
            name = ended.get()
            if code := running[name].wait():
                raise WrongStateError(f"the program of the {name} has failed with code {code}: see its words above")


def _show(name: str, line: str) -> None:
    print(f"{name}: {line.rstrip()}", flush=True)


def _show_all(name: str, process: subprocess.Popen[str], ended: queue.SimpleQueue[str]) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        _show(name, line)
    ended.put(name)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return found.getsockname()[1]
