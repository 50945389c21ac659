"""`virtualrobot console`: the cell in a browser, and the contract for whoever speaks HTTP."""

from __future__ import annotations

import os
import sys
import webbrowser
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, WholeRange, target_options
from virtualrobot.session import DEFAULT_HOST, find_token, is_loopback, split_address

if TYPE_CHECKING:
    from virtualrobot_apps.console.door import Token


@click.command(short_help="Serve the console, and the contract to browsers, curl and MATLAB.")
@click.option("--listen", "host", default=DEFAULT_HOST, metavar="ADDRESS", help="Where it listens [127.0.0.1].")
@click.option("--port", type=WholeRange(0, 65535), help="0 takes any free one [the first free one from 8090].")
@click.option("--host-name", "names", multiple=True, metavar="NAME", help="A name that browsers may call it by.")
@click.option("--origin", "origins", multiple=True, metavar="URL", help="Let pages of this origin call.")
@click.option("--tls-certificate", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="A PEM file.")
@click.option("--tls-key", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Its key, a PEM file.")
@click.option("--own-certificate", is_flag=True, help="Sign one by an authority of this installation, made once.")
@click.option(
    "--connections", type=click.Path(path_type=Path, dir_okay=False), help="Run the connections of this file."
)
@click.option("--browser/--no-browser", default=None, help="Open the page, as it is in a terminal of a desktop.")
@click.option("--end-with-input", is_flag=True, help="End when the standard input does, as for a child process.")
@target_options
def console(
    target: Target,
    host: str,
    port: int | None,
    names: tuple[str, ...],
    origins: tuple[str, ...],
    tls_certificate: Path | None,
    tls_key: Path | None,
    own_certificate: bool,
    connections: Path | None,
    browser: bool | None,
    end_with_input: bool,
) -> None:
    """Serve the console of a kernel until Ctrl-C, and print a link to it.

    The same port has all calls of the contract as Connect, gRPC-Web and JSON: docs/web.md.
    """
    if (tls_certificate is None) != (tls_key is None):
        raise click.UsageError("--tls-certificate and --tls-key go together")
    if own_certificate and tls_certificate is not None:
        raise click.UsageError("--own-certificate goes without --tls-certificate and --tls-key")
    if not is_loopback(host) and tls_certificate is None and not own_certificate:
        certificates = "give --tls-certificate and --tls-key, or --own-certificate"
        raise click.UsageError(f"{host} is reachable from other machines: {certificates}")
    for origin in origins:
        if not origin.startswith(("http://", "https://")) or origin.count("/") != 2:
            raise click.UsageError(f"{origin!r} is no origin, such as https://panel.example or http://localhost:5173")
    if find_spec("uvicorn") is None or find_spec("websockets") is None:
        raise click.UsageError("the console needs uvicorn and websockets: pip install 'virtualrobot[console]'")

    if own_certificate and find_spec("cryptography") is None:
        raise click.UsageError("--own-certificate needs cryptography: pip install 'virtualrobot[console]'")

    from virtualrobot_apps.console.serving import Kernel, Place, run

    with target.connect("console") as client:
        address, most = client.address, client.info.limits["message_bytes"]
    token = _found(split_address(address)[1], target.token_file)
    if not token() and not is_loopback(host):
        raise click.UsageError("a kernel without token isn't served to other machines: start it with one")
    kernel = Kernel(address, token, target.certificate, most, connections)
    opened = sys.stdout.isatty() and has_desktop() if browser is None else browser
    place = Place(host, port, names, origins, tls_certificate, tls_key)
    if own_certificate:
        place = place.with_own_certificate()
    run(kernel, place, click.echo, webbrowser.open if opened else None, end_with_input)


def _found(port: int, file: Path | None) -> Token:
    """Return what tells this user's token for a kernel; where there is none any more, the last one.

    Raises ValueError where what there is at first is no token.
    """
    last, _ = find_token(port, file)

    def tell() -> str:
        nonlocal last
        with suppress(ValueError):
            last = find_token(port, file)[0] or last
        return last

    return tell


def has_desktop() -> bool:
    """Return whether a browser has a window to be opened in; without one Python might start one in the terminal."""
    return sys.platform != "linux" or bool({"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys())
