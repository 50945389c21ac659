"""Pictures of the known models: each is taken once, in a world of its own, and kept in the user's cache."""

from __future__ import annotations

import asyncio
import threading

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.drawing.portrait import portrait
from virtualrobot_kernel.drawing.renderer import Renderer
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.picture_cache import PictureCache
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.scenes.alone import model_alone


class ModelPictures:
    """Pictures of known models; one is taken at a time, so that the pictures of the world go on."""

    def __init__(self, kernel: KernelServices, cache: PictureCache | None = None) -> None:
        """Keep what is taken in `cache`; None: the user's."""
        self._kernel = kernel
        self._cache = cache or PictureCache()
        self._turn = asyncio.Lock()

    async def get(self, name: str) -> bytes:
        """Return the picture of a model, a PNG file.

        Raises:
            UnknownNameError: there is no such model.
            KernelError: its package isn't installed (MISSING_FILE), or it can't be read.
        """
        models = self._kernel.catalog.models
        model = models.get(name)
        if model is None:
            raise UnknownNameError("model", name, models)
        if not model.installed:
            raise KernelError(model.how_to_install, reason=Reason.MISSING_FILE, package=model.package)
        kept = await self._kernel.in_worker(self._cache.get, model)
        if kept is not None:
            return kept
        async with self._turn:
            # Somebody else may have waited for the same one.
            image = await self._kernel.in_worker(self._cache.get, model) or await self._taken(name)
        await self._kernel.in_worker(self._cache.put, model, image)
        return image

    async def _taken(self, name: str) -> bytes:
        gone = threading.Event()
        meshes = self._kernel.meshes
        # Apart from the world's meshes, and forgotten with the picture.
        own = MeshLibrary(AssetStore(), meshes.importers, folders=meshes.folders, cache=meshes.cache)

        def take(painter: Renderer) -> bytes:
            snapshot = model_alone(f"model://{name}", own, world_poses)
            painter.check()
            return portrait(snapshot, own.load, painter.check)

        try:
            return await asyncio.wrap_future(self._kernel.renderers.submit(take, gone.is_set))
        finally:
            gone.set()
