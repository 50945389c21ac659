"""The cameras of all open viewers: set by clients of the kernel, else framing the scene until a person moves one."""

from __future__ import annotations

import time

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.framing import framed, outgrown
from virtualrobot_kernel.drawing.view import Camera
from virtualrobot_kernel.world.state import Snapshot

UNTOUCHED = 1e-3
"""In meters: a camera this near to where it was put has not been moved by hand; browsers report 32-bit positions."""

SETTLING = 1.0
"""In seconds: so long after a camera was put somewhere the browser may still tell where it was before."""


class Cameras:
    """Owns the camera of each viewer of one viser server. Call `follow` with each drawn picture."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Steer the cameras of the viewers of `server`."""
        self._server = server
        self._put: dict[int, tuple[NDArray[np.float64], float]] = {}
        self._asked: Camera | None = None
        self._placed: Camera | None = None
        self._framed: NDArray[np.float64] | None = None

    def follow(self, asked: Camera | None, snapshot: Snapshot, bounds: NDArray[np.float64] | None) -> None:
        """Look from where the settings ask; without that, frame the scene whenever it outgrows the last frame.

        Args:
            asked: the camera of the settings; each new object moves all viewers, be it equal to the last or not, and so
                does its node where it goes along with one.
            snapshot: where nodes are; a camera of one that is gone is none.
            bounds: (2, 3) box around the scene in meters in the world's frame, or None while it is empty.
        """
        clients = self._server.get_clients()
        self._put = {
            key: self._put[key] if key in self._put else (np.array(client.camera.position), time.monotonic())
            for key, client in clients.items()
        }
        placed = asked.placed(snapshot) if asked is not None else None
        if placed is None:
            asked = None
        if placed is not None:
            if asked is not self._asked or placed != self._placed:
                self._move(placed, clients)
            self._framed = None
        elif bounds is not None and (self._asked is not None or outgrown(self._framed, bounds)):
            untouched = {
                key: client
                for key, client in clients.items()
                if self._asked is not None or self._untouched(key, client)
            }
            self._move(framed(bounds), untouched)
            self._framed = bounds
        self._asked, self._placed = asked, placed

    def _untouched(self, key: int, client: viser.ClientHandle) -> bool:
        eye, moment = self._put[key]
        return time.monotonic() < moment + SETTLING or np.allclose(client.camera.position, eye, atol=UNTOUCHED)

    def _move(self, camera: Camera, clients: dict[int, viser.ClientHandle]) -> None:
        """Put the cameras of these viewers, and of those that come later, to one place."""
        eye, target = np.array(camera.position), np.array(camera.target)
        view = target - eye
        if np.hypot(view[0], view[1]) < 1e-3 * abs(view[2]):
            # Straight up or down, which way is up in the picture is not defined; a hair beside it, +y is.
            eye[1] -= 1e-3 * abs(view[2])
        first = self._server.initial_camera
        first.position, first.look_at, first.fov = eye, target, camera.field_of_view
        for key, client in clients.items():
            with client.atomic():
                client.camera.up_direction = (0.0, 0.0, 1.0)
                client.camera.position = eye
                client.camera.look_at = target
                client.camera.fov = camera.field_of_view
            self._put[key] = eye, time.monotonic()
