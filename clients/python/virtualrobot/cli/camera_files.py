"""Pictures of cameras as files and in words."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from virtualrobot.sensors.cameras import CameraReading
    from virtualrobot.sensors.readings import Reading

KINDS = ("color", "depth", "segmentation", "normals")


def picture_words(seen: CameraReading) -> str:
    """Return what was taken in words."""
    taken = ", ".join(kind for kind in KINDS if getattr(seen, kind) is not None)
    return f"{seen.width} x {seen.height} pixels{', two eyes' if seen.right else ''}: {taken}"


def write_pictures(path: Path, reading: Reading) -> None:
    """Write the pictures of a camera and what is needed to use them as arrays (.npz)."""
    import numpy as np

    seen = reading.camera
    eyes = {"": seen, "right_": seen.right} if seen.right else {"": seen}
    pictures = {f"{eye}{kind}": getattr(one, kind) for eye, one in eyes.items() for kind in KINDS}
    np.savez_compressed(
        path,
        **{name: array for name, array in pictures.items() if array is not None},
        element_names=np.array(seen.element_names, np.str_),
        camera_matrix=seen.camera_matrix,
        distortion=seen.distortion,
        projection=seen.projection,
        stereo_baseline=seen.stereo_baseline,
        world_t_sensor=reading.world_t_sensor,
        simulation_time_seconds=reading.stamp.simulation_time,
    )
