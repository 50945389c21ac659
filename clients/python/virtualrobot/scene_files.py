"""Models and scene files: sent to the kernel with all that they name, and taken from it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import NoReturn

from numpy.typing import ArrayLike

from virtualrobot.assets import Assets, Upload
from virtualrobot.errors import InvalidArgumentError, MissingFileError, VirtualRobotError
from virtualrobot.resolver import Resolver, UnresolvedUriError
from virtualrobot.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.v1 import nodes_pb2, scene_pb2
from virtualrobot.wire import pose_message, vector_message

_BASES = {
    "fixed": nodes_pb2.JOINT_TYPE_FIXED,
    "floating": nodes_pb2.JOINT_TYPE_FLOATING,
    "planar": nodes_pb2.JOINT_TYPE_PLANAR,
}


def load_model(
    services: Services,
    assets: Assets,
    file: str | Path,
    name: str,
    pose: ArrayLike | None,
    parent: str,
    packages: Mapping[str, str | Path],
    base: str,
    as_part: bool,
    scale: float | Sequence[float],
) -> scene_pb2.ImportModelResponse:
    """Import a model; the arguments are those of `Scene.load`."""
    if base not in _BASES:
        raise InvalidArgumentError(f"base is {', '.join(_BASES)}, not {base!r}")
    factors = (scale,) * 3 if isinstance(scale, int | float) else tuple(scale)
    request = scene_pb2.ImportModelRequest(
        name=name, parent=parent, base_joint=_BASES[base], as_part=as_part, scale=vector_message(factors, "a scale")
    )
    if pose is not None:
        request.parent_t_node.CopyFrom(pose_message(pose))
    upload = Upload(str(file))
    try:
        Resolver(packages).resolve(str(file))
    except UnresolvedUriError as error:
        # Perhaps it is on the kernel's machine.
        upload.missing[str(file)] = error
        request.packages.update({package: str(folder) for package, folder in packages.items()})
    else:
        upload = assets.upload_with_references(file, packages)
    request.uri = upload.uri
    request.files.extend(upload.messages())
    try:
        return services.scene.ImportModel(request, timeout=LONG_TIMEOUT_SECONDS)
    except MissingFileError as error:
        _say_where(error, upload)


def load_scene(
    services: Services, assets: Assets, file: Path, add: bool, packages: Mapping[str, str | Path]
) -> scene_pb2.LoadSceneResponse:
    """Load a scene file of this machine; the arguments are those of `Scene.load_scene`."""
    upload = assets.upload_with_references(file, packages)
    try:
        text = Path(upload.uri).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidArgumentError(f"{file} is no scene file: it is not text in UTF-8: {error}") from error
    request = scene_pb2.LoadSceneRequest(text=text, uri=upload.uri, files=upload.messages(), add=add)
    try:
        return services.scene.LoadScene(request, timeout=LONG_TIMEOUT_SECONDS)
    except MissingFileError as error:
        _say_where(error, upload)


def save_scene(services: Services, assets: Assets, file: Path, bundle: bool) -> list[Path]:
    """Save the world; the arguments are those of `Scene.save`."""
    request = scene_pb2.SaveSceneRequest(bundle=bundle)
    response = services.scene.SaveScene(request, timeout=LONG_TIMEOUT_SECONDS)
    written = []
    for asset in response.files:
        relative = PurePosixPath(asset.uri)
        if relative.is_absolute() or ".." in relative.parts:
            raise VirtualRobotError(f"the kernel names a file outside the bundle: {asset.uri!r}")
        written.append(_write(file.parent / relative, assets.download(asset.sha256)))
    # Last, so that a scene file never names assets that are not there yet.
    written.append(_write(file, response.text.encode()))
    return written


def _write(path: Path, data: bytes) -> Path:
    """Write a file as a whole or not at all; return its path."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        # mkstemp makes files that only their owner can read; a saved scene is an ordinary file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except OSError as error:
        raise InvalidArgumentError(f"{path} cannot be written: {error.strerror or error}") from error
    return path


def _say_where(error: MissingFileError, upload: Upload) -> NoReturn:
    """Raise the kernel's error with the places on this machine that were tried."""
    here = upload.missing.get(error.metadata.get("file", ""))
    if here is None:
        raise error
    raise MissingFileError(
        f"{here} (on this machine); the kernel does not have it either", error.reason, error.metadata, error.code
    ) from error
