"""Cameras of a world that take the pictures of walls: off-axis frusta are pinholes that look past the middle."""

from __future__ import annotations

from virtualrobot.connection import Client
from virtualrobot.sensors.cameras import camera

from virtualrobot_apps.walls.display import views
from virtualrobot_apps.walls.head import Observer


def add_cameras(client: Client, observer: Observer, name: str) -> list[str]:
    """Add a frame for the room and below it a camera for each picture, all or none, and return the cameras' names.

    They look as the head stands now, and are moved with the frame.

    Raises:
        NameTakenError: where there are such nodes already.
    """
    added = list[str]()
    with client.scene.batch() as batch:
        batch.add_frame(name, pose=observer.world_t_room)
        for view in views(observer.display, observer.room_t_head):
            _, _, width, height = view.viewport
            settings = camera(
                width,
                height,
                camera_matrix=view.frustum.camera_matrix(width, height),
                near=observer.display.near,
                far=observer.display.far,
            )
            added.append(f"{name}_{view.wall}_{view.eye}")
            batch.add_camera(added[-1], settings, pose=view.frustum.room_t_camera, parent=name)
    return added
