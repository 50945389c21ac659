"""`virtualrobot ros`: a world under ROS, without ROS: for roslibpy, roslib, rosbridge's other clients, and by DDS."""

from __future__ import annotations

import secrets
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.own_kernel import interrupt_when_terminated

if TYPE_CHECKING:
    from virtualrobot_apps.bridges.ros.transport import Transport

_LOOPBACK = ("127.0.0.1", "::1", "localhost")

_EXAMPLES = """
\b
Examples:
  virtualrobot ros
  virtualrobot ros bridge.yaml --no-auto
  virtualrobot ros --map floor.yaml
  virtualrobot ros --server ws://192.168.0.5:9090
  virtualrobot ros --lines 9091
  virtualrobot ros --dds --domain 7
  virtualrobot ros --dds --rmw cyclonedds
  virtualrobot ros --zenoh --domain 7
  virtualrobot ros --rclpy
  virtualrobot ros --ros1
  virtualrobot ros --simuep scene.xml
  virtualrobot ros --host 0.0.0.0 --client-token-file rosbridge.token
"""


@click.command(epilog=_EXAMPLES, short_help="Bridge a world to ROS: rosbridge for roslibpy, roslib and others.")
@click.argument("mapping", type=click.Path(path_type=Path, dir_okay=False), required=False, metavar="[BRIDGE.YAML]")
@click.option("--auto/--no-auto", default=True, help="Whether streams that the file leaves out are told, too. [told]")
@click.option("--bare-links", is_flag=True, help="Call links as in the URDF: link_1 in place of arm/link_1.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Where rosbridge serves.")
@click.option("--port", default=9090, show_default=True, type=click.IntRange(0, 65535), help="Its port; 0 is any.")
@click.option(
    "--lines",
    type=click.IntRange(0, 65535),
    metavar="PORT",
    help="Serve the same there, too, as lines of JSON by plain TCP.",
)
@click.option("--origin", "origins", multiple=True, help="Pages of this origin may connect, too; may be given again.")
@click.option(
    "--client-token-file",
    "client_token",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Ask clients for the token in this file, which is made where it is not there.",
)
@click.option("--no-client-token", is_flag=True, help="Let everybody in who reaches the host.")
@click.option("--dds", is_flag=True, help="Be a node of ROS 2, by Cyclone DDS.")
@click.option(
    "--rmw",
    type=click.Choice(["any", "cyclonedds"]),
    default="any",
    show_default=True,
    help="On what the node's peers run: for rmw_cyclonedds it has services and actions, too, not only topics.",
)
@click.option("--zenoh", is_flag=True, help="Be a node of ROS 2 on rmw_zenoh.")
@click.option(
    "--zenoh-router",
    default="tcp/localhost:7447",
    show_default=True,
    metavar="ADDRESS",
    help="The router of rmw_zenoh, by which nodes find each other.",
)
@click.option(
    "--domain", default=0, show_default=True, type=click.IntRange(0, 232), help="The domain of DDS and of zenoh."
)
@click.option("--rclpy", is_flag=True, help="Be a node of this shell's ROS 2, by its own rclpy, on any middleware.")
@click.option(
    "--ros1", is_flag=True, help="Be a node of ROS 1; where there is no master on this machine it brings one."
)
@click.option(
    "--master",
    envvar="ROS_MASTER_URI",
    default="http://127.0.0.1:11311",
    show_default=True,
    metavar="URL",
    help="The master of ROS 1, as in ROS_MASTER_URI.",
)
@click.option(
    "--ros1-host",
    default="127.0.0.1",
    show_default=True,
    help="This machine as nodes of ROS 1 reach it, which know no tokens: who reaches it may move the robots.",
)
@click.option("--foxglove", is_flag=True, help="Serve Foxglove and Lichtblick on this machine, too.")
@click.option("--foxglove-port", default=8765, show_default=True, type=click.IntRange(0, 65535), help="Their port.")
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Record all that is told and heard: FILE.mcap or a folder in the form of ROS 2, FILE.bag in that of ROS 1.",
)
@click.option(
    "--play",
    type=click.Path(path_type=Path, exists=True),
    metavar="FILE",
    help="Play a bag of ROS 1 or 2 (.bag, .mcap, a folder) in simulation time, but for what the world tells itself.",
)
@click.option(
    "--files",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    metavar="FOLDER",
    help="Let programs such as ROS# keep files of robots in this folder.",
)
@click.option(
    "--simuep",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="SCENE.xml",
    help="Replace the world by this scene file of SimUEP-Robotics, and serve the topics and services that it names.",
)
@click.option(
    "--map",
    "floor",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="MAP",
    help="Tell this map of a floor (.yaml, as `virtualrobot navigate` and map_server have it), or octree (.bt, .ot).",
)
@click.option(
    "--simulation-interfaces",
    "interfaces",
    type=click.Choice(["1", "2"]),
    default="2",
    show_default=True,
    help="Version of simulation_interfaces: 2.1, or 1.0 as other programs may still have it.",
)
@click.option("--server", metavar="URL", help="Be a client of this rosbridge_server, too: ws://HOST:9090.")
@click.option(
    "--server-token-file",
    "server_token",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="The token in this file goes along, as a bearer's.",
)
@click.option("--check", is_flag=True, help="Look at the file and at the streams, and serve nothing.")
@target_options
def ros(
    target: Target,
    mapping: Path | None,
    auto: bool,
    bare_links: bool,
    host: str,
    port: int,
    lines: int | None,
    origins: tuple[str, ...],
    client_token: Path | None,
    no_client_token: bool,
    dds: bool,
    rmw: str,
    zenoh: bool,
    zenoh_router: str,
    domain: int,
    rclpy: bool,
    ros1: bool,
    master: str,
    ros1_host: str,
    foxglove: bool,
    foxglove_port: int,
    record: Path | None,
    play: Path | None,
    files: Path | None,
    simuep: Path | None,
    floor: Path | None,
    interfaces: str,
    server: str | None,
    server_token: Path | None,
    check: bool,
) -> None:
    """Tell ROS what a world tells, and hear what it hears, until Ctrl-C.

    All streams have conventional names; the file BRIDGE.YAML gives others. No ROS is needed, here or there.
    """
    try:
        from virtualrobot_apps.bridges.ros.bridge import RosBridge
        from virtualrobot_apps.bridges.ros.bridge_file import Choice, read_choice
        from virtualrobot_apps.bridges.ros.memory import keep_memory
        from virtualrobot_apps.bridges.ros.messages import types
        from virtualrobot_apps.bridges.ros.rosbridge.client import RosbridgeClient
        from virtualrobot_apps.bridges.ros.rosbridge.server import RosbridgeServer
        from virtualrobot_apps.bridges.ros.simuep.loading import load_simuep
        from virtualrobot_apps.bridges.ros.simuep.topics import choice_of
        from virtualrobot_apps.bridges.ros.transport import TransportError
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[ros]'") from error
    if host not in _LOOPBACK and client_token is None and not no_client_token:
        raise click.UsageError(
            f"whoever reaches {host} could move the robots: say --client-token-file FILE, or --no-client-token"
        )
    if floor is not None and floor.suffix == ".yaml" and find_spec("scipy") is None:
        raise click.UsageError("a map needs scipy: pip install 'virtualrobot[ros,navigation]'")
    if mapping and simuep:
        raise click.UsageError("a BRIDGE.YAML and --simuep both name topics: say one of them")
    if interfaces == "1":
        types.replace(types.FILE.parent / "simulation_interfaces_1.yaml")
    choice = read_choice(mapping, auto=auto) if mapping else Choice(auto)
    token = _token(client_token) if client_token else ""
    transports: list[Transport] = [RosbridgeServer(host, port, token=token, origins=origins)]
    if lines is not None:
        from virtualrobot_apps.bridges.ros.rosbridge.lines import LineServer

        transports.append(LineServer(host, lines, token=token))
    if dds:
        transports.append(_dds_node(domain, services=rmw == "cyclonedds"))
    if zenoh:
        transports.append(_zenoh_node(zenoh_router, domain))
    if rclpy:
        transports.append(_rclpy_node())
    if ros1:
        from virtualrobot_apps.bridges.ros.ros1.node import Ros1Node

        transports.append(Ros1Node(master, ros1_host, say=click.echo))
    if foxglove:
        transports.append(_foxglove_server(foxglove_port))
    if server is not None:
        word = server_token.read_text("utf-8").strip() if server_token else ""
        transports.append(RosbridgeClient(server, token=word, say=click.echo))
    elif server_token is not None:
        raise click.UsageError("--server-token-file is the token of a --server")
    if record is not None:
        transports.append(_recorder(record))
    if play is not None:
        from virtualrobot_apps.bridges.ros.player import Player

        transports.append(Player(play, click.echo))
    keep_memory()
    with target.connect("ros bridge") as client:
        scene = load_simuep(client, simuep, click.echo) if simuep else None
        if scene is not None:
            choice = choice_of(scene, auto)
        bridge = RosBridge(
            client,
            transports,
            choice,
            bare=bare_links,
            simuep=scene,
            files=files,
            floor=floor,
            name=f"the bridge at port {port}",
            say=click.echo,
        )
        if check:
            click.echo("\n".join(bridge.check()))
            return
        interrupt_when_terminated()  # recordings are ended well
        try:
            bridge.run()
        except TransportError as error:
            raise click.ClickException(str(error)) from error


def _dds_node(domain: int, *, services: bool) -> Transport:
    try:
        from virtualrobot_apps.bridges.ros.dds.node import DdsNode
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[dds]'") from error
    return DdsNode(domain, services=services)


def _zenoh_node(router: str, domain: int) -> Transport:
    try:
        from virtualrobot_apps.bridges.ros.zenoh_node import ZenohNode
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[zenoh]'") from error
    return ZenohNode(router, domain)


def _rclpy_node() -> Transport:
    try:
        from virtualrobot_apps.bridges.ros.rclpy_node import RclpyNode
    except ImportError as error:  # of a library of ROS, too, that is not found
        words = "source the setup of your ROS 2 first, and install virtualrobot for the Python that it is of"
        raise click.UsageError(f"{error}; {words}") from error
    return RclpyNode(say=click.echo)


def _foxglove_server(port: int) -> Transport:
    try:
        from virtualrobot_apps.bridges.ros.foxglove_server import FoxgloveServer
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[foxglove]'") from error
    return FoxgloveServer(port=port)


def _recorder(file: Path) -> Transport:
    try:
        from virtualrobot_apps.bridges.ros.recorder import Recorder
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[record]'") from error
    return Recorder(file)


def _token(file: Path) -> str:
    """Return the token of a file, which is written for its owner alone where it is not there."""
    if not file.exists():
        file.touch(mode=0o600)
        file.write_text(secrets.token_urlsafe(32) + "\n", "utf-8")
    token = file.read_text("utf-8").strip()
    if not token:
        raise click.UsageError(f"{file} is empty; without it one is made")
    return token
