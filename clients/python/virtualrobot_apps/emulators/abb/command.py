"""`virtualrobot emulate abb`."""

from __future__ import annotations

import asyncio
import queue
import re
import socket
import sys
import threading
from contextlib import ExitStack, suppress
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import click
from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, Target, target_options

from virtualrobot_apps.emulators.egm.command import devices_option

_EXAMPLES = """
\b
Examples:
  virtualrobot emulate abb arm
  virtualrobot emulate abb arm --module palletize.mod --create-signals --port 8080
  virtualrobot emulate abb left right --module left.mod --module T_ROB2=right.mod --files disk
  virtualrobot emulate abb arm --module guided.mod --egm UCdevice=127.0.0.1:6510
"""


_PEM = click.Path(exists=True, dir_okay=False, path_type=Path)

SWITCH_SECONDS = 0.0005
"""Time (s) after which a program that computes without a wait lets the server answer; Python has ten times that."""


@click.command(epilog=_EXAMPLES)
@click.argument("robots", nargs=-1, required=True, metavar="ROBOT...", type=ROBOT)
@click.option(
    "--module", "modules", multiple=True, metavar="[TASK=]FILE", help="Load a module into a task [T_ROB1] at the start."
)
@click.option("--host", default="127.0.0.1", show_default=True, help="The address to listen at.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8080, show_default=True, help="Its port; 0: any free one."
)
@click.option(
    "--rws",
    "version",
    type=click.Choice(["1.0", "2.0"]),
    default="1.0",
    show_default=True,
    help="Robot Web Services: those of RobotWare 6, or of RobotWare 7, which are HTTPS.",
)
@click.option("--tls-certificate", type=_PEM, help="With --rws 2.0: a PEM file.")
@click.option("--tls-key", type=_PEM, help="Its key, a PEM file.")
@click.option("--user", default="Default User", show_default=True, help="Who may come in.")
@click.option("--password", default="robotics", show_default=True, help="The password, here the one that ABB ships.")
@click.option(
    "--files",
    "folder",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    help="The folder that the controller's disks are [one that is deleted at the end].",
)
@click.option(
    "--listen",
    metavar="[ADDRESS]",
    is_flag=False,
    flag_value="127.0.0.1",
    help="Let sockets of programs listen, at this address [127.0.0.1].",
)
@devices_option
@click.option(
    "--motion-programs",
    is_flag=True,
    help="Run what abb-motion-program-exec uploads: a module and its signals are added.",
)
@click.option("--create-signals", is_flag=True, help="Add the signals that modules name and the world has not.")
@click.option("--until-input-ends", is_flag=True, help="End with the standard input: with the program that started it.")
@target_options
def abb(
    target: Target,
    robots: tuple[str, ...],
    modules: tuple[str, ...],
    host: str,
    port: int,
    version: str,
    tls_certificate: Path | None,
    tls_key: Path | None,
    user: str,
    password: str,
    folder: Path | None,
    listen: str | None,
    devices: tuple[tuple[str, tuple[str, int]], ...],
    motion_programs: bool,
    create_signals: bool,
    until_input_ends: bool,
) -> None:
    """Emulate an ABB controller with Robot Web Services, whose programs in RAPID move ROBOTs, until Ctrl-C.

    Clients load, start, watch and stop programs; T_ROB1 moves the first ROBOT. Lines that are typed are answers on the
    pendant. Whoever knows user and password moves the robots.
    """
    if find_spec("uvicorn") is None or find_spec("websockets") is None:
        raise click.UsageError("this needs uvicorn and websockets: pip install 'virtualrobot[console]'")
    second = version == "2.0"
    certificate = None if tls_certificate is None or tls_key is None else (tls_certificate, tls_key)
    if second != (certificate is not None) or (certificate is None and (tls_certificate or tls_key)):
        raise click.UsageError("--tls-certificate and --tls-key go with --rws 2.0, which is HTTPS and needs both")
    from virtualrobot_apps.emulators.abb.controller import Controller
    from virtualrobot_apps.emulators.abb.refused import Refused
    from virtualrobot_apps.emulators.abb.server import Server, made
    from virtualrobot_apps.languages.core.source import read_source

    sys.setswitchinterval(SWITCH_SECONDS)
    with ExitStack() as stack:
        client = stack.enter_context(target.connect("ABB emulator"))
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would move; {GO_ON}")
        files = folder or Path(stack.enter_context(TemporaryDirectory(prefix="virtualrobot-abb-")))
        try:
            listening = socket.create_server((host, port))
        except OSError as error:
            said = f"{host}, port {port} can't be listened at: {error.strerror or error}"
            raise click.ClickException(f"{said}; --port takes another one") from error
        stack.callback(listening.close)
        listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        typed: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        answers = iter(typed.get, None)
        creates = create_signals or motion_programs
        controller = Controller(
            client,
            robots,
            files,
            create_signals=creates,
            listen_at=listen,
            write=click.echo,
            answers=answers,
            egm=dict(devices),
        )
        stack.callback(controller.close)
        if motion_programs:
            controller.load_motion_programs()
        for text in modules:
            found = re.fullmatch(r"((?P<task>\w+)=)?(?P<file>.+)", text, re.DOTALL)
            assert found is not None
            try:
                controller.load_module(found["task"] or "T_ROB1", read_source(Path(found["file"])), replace=True)
            except Refused as error:
                raise click.ClickException(error.words) from error
        server = made(Server(controller, {user: password}, second=second), certificate)
        try:
            server.config.load()
        except OSError as error:
            said = f"--tls-certificate and --tls-key are no certificate and its key: {error}"
            raise click.ClickException(said) from error
        click.echo(f"Robot Web Services at http{'s' * second}://{host}:{listening.getsockname()[1]}; Ctrl-C ends it")

        def read() -> None:
            for line in sys.stdin:
                typed.put(line)
            typed.put(None)
            server.should_exit = server.should_exit or until_input_ends

        threading.Thread(target=read, name="input", daemon=True).start()
        with suppress(KeyboardInterrupt):
            asyncio.run(server.serve([listening]))
