"""Pages that play a run without a kernel: an animated scene and its player in one file (`.html`)."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Mapping
from html import escape
from importlib.resources import files
from typing import BinaryIO

from virtualrobot.errors import WrongStateError

PLAYER = "player/player.js"

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="VirtualRobot {version}">
<title>{title}</title>
<link rel="icon" href="data:,">
</head>
<body>
<noscript>This page needs JavaScript, which is in it; nothing is loaded from elsewhere.</noscript>
<script type="application/octet-stream" id="run">{run}</script>
<script type="module">{player}</script>
</body>
</html>
"""


def player() -> str:
    """Return the program that plays a run, as it is built with the console's page.

    Raises:
        WrongStateError: when it is not built.
    """
    file = files("virtualrobot.recording") / PLAYER
    if not file.is_file():
        raise WrongStateError("the player of .html recordings is not built: run `make console` in the clone")
    return file.read_text(encoding="utf-8")


def page_file(stream: BinaryIO, program: str) -> Callable[[bytes, Mapping[str, str]], None]:
    """Return what writes an animated scene (GLB) to a page with the program that plays it."""

    def write(data: bytes, about: Mapping[str, str]) -> None:
        # A script ends at the first such letters, wherever they stand.
        text = _PAGE.format(
            title=escape(about.get("name", "A run of VirtualRobot")),
            version=escape(about.get("version", "")),
            run=b64encode(data).decode("ascii"),
            player=program.replace("</script", "<\\/script"),
        )
        stream.write(text.encode())

    return write
