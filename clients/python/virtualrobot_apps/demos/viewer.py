"""The viewer of the kernel that a demonstration runs in, as people at this machine see it."""

from __future__ import annotations

import os
import sys
import webbrowser

from virtualrobot import Client


def show_viewer(client: Client, headless: bool) -> None:
    """Print the viewer's address, and open it in a browser unless `headless` or where there is no desktop."""
    url = client.info.viewer_url
    if not url:
        return
    print(f"viewer at {url}", flush=True)
    # Without a desktop Python might start a text browser in this terminal.
    if not headless and (sys.platform != "linux" or {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()):
        webbrowser.open(url)
