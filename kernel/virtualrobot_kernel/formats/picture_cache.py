"""Small pictures of models on the disk, from kernel to kernel, by what they depend on."""

from __future__ import annotations

import contextlib
import hashlib
import logging
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from platformdirs import user_cache_dir
from virtualrobot_sdk.models import Model

from virtualrobot_kernel.version import VERSION
from virtualrobot_kernel.whole_files import write_whole

log = logging.getLogger(__name__)


class PictureCache:
    """Cache of a PNG file for each model; any thread and any number of kernels may ask.

    A picture is that of a model as its plugin and its package have it now: others are taken anew.
    """

    def __init__(self, folder: Path | None = None) -> None:
        """Keep them in `folder`, which is made when something is put; None: the user's."""
        self._folder = folder or Path(user_cache_dir("virtualrobot")) / "models"

    def get(self, model: Model) -> bytes | None:
        """Return the picture of a model, or None."""
        try:
            return self._path(model).read_bytes()
        except OSError:
            return None

    def put(self, model: Model, picture: bytes) -> None:
        """Keep the picture of a model; where that fails, do without."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_whole(self._path(model), picture)
        except OSError as error:
            log.info("the picture of the model %s is not kept: %s", model.name, error)

    def _path(self, model: Model) -> Path:
        package = ""
        with contextlib.suppress(PackageNotFoundError):
            package = version(model.package) if model.package else ""
        return self._folder / f"{hashlib.sha256(repr((model, package, VERSION)).encode()).hexdigest()}.png"
