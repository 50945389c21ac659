"""Stands in for a browser before a viser server: connects, and takes all that is sent until it is ended.

Usage: python benchmarks/browser.py 8080
It prints a line once it is connected and then, twice a second, how many messages it has taken so far.
"""

from __future__ import annotations

import sys
import time

import msgspec
import viser
from websockets.sync.client import connect
from websockets.typing import Subprotocol

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (3.0, 3.0, 3.0),
    "fov": 0.9,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 900,
    "image_width": 1600,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


def main(port: int) -> None:
    """Take messages for as long as the server sends any."""
    subprotocol = Subprotocol(f"viser-v{viser.__version__}")
    with connect(f"ws://127.0.0.1:{port}", subprotocols=[subprotocol], max_size=None) as socket:
        socket.send(msgspec.msgpack.encode(CAMERA))
        print("connected", flush=True)
        count, told = 0, time.monotonic()
        for _ in socket:
            count += 1
            if time.monotonic() > told + 0.5:
                print(count, flush=True)
                told = time.monotonic()


if __name__ == "__main__":
    main(int(sys.argv[1]))
