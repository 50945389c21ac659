"""Check of scene files without a world: for the test kit of importers, which finds this by its entry point."""

from __future__ import annotations

from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.scenes.models import spec_of


def check_scene(data: bytes) -> None:
    """Raise KernelError, UnicodeDecodeError for a scene file that the kernel refuses for its text or its values.

    What it names (models, meshes, parents in other files) is not looked for.
    """
    scene = scene_file.parse(data.decode("utf-8"))
    for place, node in enumerate(scene.nodes):
        spec_of(node, f"nodes[{place}]")
