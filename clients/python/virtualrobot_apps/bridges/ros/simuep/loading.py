"""Scene files of SimUEP-Robotics, put into a kernel's world."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError

from virtualrobot_apps.bridges.ros.simuep.scene import SimuepScene, read_scene


def load_simuep(client: Client, file: Path, say: Callable[[str], None] = print) -> SimuepScene:
    """Replace a kernel's world by a scene file, whose observer people look from, and return what it says.

    Raises:
        MissingFileError: when the file or one that it names is nowhere.
        MalformedFileError: for anything in it that is wrong.
        InvalidArgumentError: when its folder can't be written, where what the kernel reads lies for a moment.
    """
    scene = read_scene(file)
    for words in scene.left_out:
        say(words)
    try:  # beside it, since files that it names count from there
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", suffix=".yaml", prefix=f".{file.stem}-", dir=file.parent, delete=False
        ) as out:
            json.dump(scene.scene, out)
    except OSError as error:
        raise InvalidArgumentError(f"the folder of {file} cannot be written: {error.strerror or error}") from error
    try:
        client.scene.load_scene(out.name)
    except VirtualRobotError as error:
        words = str(error).replace(out.name, str(file))
        raise type(error)(words, error.reason, error.metadata, error.code) from error
    finally:
        Path(out.name).unlink(missing_ok=True)
    if scene.observer is not None:
        eye, ahead = scene.observer[:3, 3], scene.observer[:3, 0]
        client.view.set_camera(eye, np.add(eye, ahead))
    return scene
