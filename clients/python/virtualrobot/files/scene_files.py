"""Models and scene files: sent to the kernel with all that they name, and taken from it."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from virtualrobot._wire.arguments import PoseLike
from virtualrobot._wire.messages import pose_message, settings_message
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError, MissingFileError
from virtualrobot.files.assets import Assets, Upload
from virtualrobot.files.resolver import Resolver, UnresolvedUriError
from virtualrobot.files.usdz import usdz_of
from virtualrobot.files.writing import write_beside, write_file
from virtualrobot.v1 import nodes_pb2, scene_pb2

log = logging.getLogger(__name__)

_KNOWN_MODEL = re.compile(r"model://[^/]+")
_BASES = {
    "fixed": nodes_pb2.JOINT_TYPE_FIXED,
    "floating": nodes_pb2.JOINT_TYPE_FLOATING,
    "planar": nodes_pb2.JOINT_TYPE_PLANAR,
}


@shown
@dataclass(frozen=True, slots=True)
class Export:
    """Export by `Scene.export`: `files`, the main one last, and `warnings` of what the format could not express."""

    files: tuple[Path, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FileWarning:
    """Something odd about a file that was loaded all the same.

    Attributes:
        file: the whole name of the file.
        line: from 1; 0 where none is known.
        text: in words, with the file's name and the line before them.
    """

    file: str
    line: int
    text: str

    def __str__(self) -> str:
        """Return the text."""
        return self.text


def model_request(name: str | None, pose: PoseLike | None, parent: str, base: str) -> scene_pb2.ModelSource:
    """Return the request for a model that goes there; the arguments are those of `Scene.load`."""
    if base not in _BASES:
        raise InvalidArgumentError(f"base is {', '.join(_BASES)}, not {base!r}")
    request = scene_pb2.ModelSource(name=name, parent=parent, base_joint=_BASES[base])
    if pose is not None:
        request.parent_t_node.CopyFrom(pose_message(pose))
    return request


def load_model(
    services: Services,
    assets: Assets,
    request: scene_pb2.ModelSource,
    file: str | Path,
    srdf: str | Path | None,
    packages: Mapping[str, str | Path],
    settings: Mapping[str, object] | None,
    request_id: str | None = None,
    text: str | None = None,
) -> scene_pb2.ImportModelResponse:
    """Import a model from a file of this machine, from a text that `file` names, or one that the kernel knows."""
    if settings:
        request.settings.CopyFrom(settings_message(settings))
    if text is None:
        upload = _sent(assets, file, packages, settings)
    else:
        upload = assets.upload_with_references(file, packages, settings, text=text)
    request.uri = upload.uri
    if srdf is not None:
        beside = _sent(assets, srdf, packages, settings)
        request.srdf_uri = beside.uri
        upload = Upload(upload.uri, beside.files | upload.files, beside.missing | upload.missing)
    request.files.extend(upload._messages())
    try:
        asked = scene_pb2.ImportModelRequest(model=request, request_id=request_id)
        return services.scene.ImportModel(asked, timeout=LONG_TIMEOUT_SECONDS)
    except MissingFileError as error:
        _say_where(error, upload)


def _sent(
    assets: Assets, file: str | Path, packages: Mapping[str, str | Path], settings: Mapping[str, object] | None
) -> Upload:
    """Send a file with all that it names; leave one that is not here to the kernel, which may have it."""
    uri = str(file)
    try:
        Resolver(packages).resolve(uri)
    except UnresolvedUriError as error:
        # A model that the kernel knows by name is no file of this machine.
        return Upload(uri, missing={} if _KNOWN_MODEL.fullmatch(uri) else {uri: error})
    return assets.upload_with_references(file, packages, settings)


def load_scene(
    services: Services,
    assets: Assets,
    file: Path,
    add: bool,
    packages: Mapping[str, str | Path],
    strict: bool,
    request_id: str | None,
) -> scene_pb2.LoadSceneResponse:
    """Load a scene file of this machine; the arguments are those of `Scene.load_scene`."""
    upload = assets.upload_with_references(file, packages)
    try:
        text = Path(upload.uri).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidArgumentError(f"{file} is no scene file: it is not text in UTF-8: {error}") from error
    request = scene_pb2.LoadSceneRequest(
        text=text, uri=upload.uri, files=upload._messages(), add=add, strict=strict, request_id=request_id
    )
    try:
        return services.scene.LoadScene(request, timeout=LONG_TIMEOUT_SECONDS)
    except MissingFileError as error:
        _say_where(error, upload)


def save_scene(services: Services, assets: Assets, file: Path, bundle: bool) -> list[Path]:
    """Save the world; the arguments are those of `Scene.save`."""
    request = scene_pb2.SaveSceneRequest(bundle=bundle)
    response = services.scene.SaveScene(request, timeout=LONG_TIMEOUT_SECONDS)
    written = write_beside(file.parent, response.files, assets)
    # Last, so that a scene file never names assets that are not there yet.
    return [*written, write_file(file, response.text.encode())]


def export_model(services: Services, assets: Assets, node: str, file: Path, tolerance: float = 0.0) -> Export:
    """Export what hangs below a node; the arguments are those of `Scene.export`."""
    is_still = file.suffix.lower() == ".usdz"
    if is_still and tolerance:
        raise InvalidArgumentError("only .glb can be written with a tolerance, not .usdz; leave the tolerance out")
    format = ".glb" if is_still else file.suffix.lower()
    request = scene_pb2.ExportModelRequest(node=node, format=format, tolerance_meters=tolerance)
    response = services.scene.ExportModel(request, timeout=LONG_TIMEOUT_SECONDS)
    main, *others = response.files
    # Meshes of two robots may have the same names; those of this one may be there from its last export.
    written = write_beside(file.parent, others, assets, replace=file.exists())
    # Last, so that the main file never names others that are not there yet.
    data = assets.download(main.sha256)
    written.append(write_file(file, usdz_of(data) if is_still else data))
    return Export(tuple(written), tuple(response.warnings))


def file_warnings(warnings: Iterable[scene_pb2.FileWarning]) -> tuple[FileWarning, ...]:
    """Return and log what was left out or changed of a file; where nobody sets up logging, Python prints it."""
    told = tuple(FileWarning(warning.file, warning.line, warning.text) for warning in warnings)
    for warning in told:
        log.warning("%s", warning)
    return told


def _say_where(error: MissingFileError, upload: Upload) -> NoReturn:
    """Raise the kernel's error with the places on this machine that were tried."""
    here = upload.missing.get(error.metadata.get("file", ""))
    if here is None:
        raise error
    raise MissingFileError(
        f"{here} (on this machine); the kernel does not have it either", error.reason, error.metadata, error.code
    ) from error
