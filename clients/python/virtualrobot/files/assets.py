"""Files to and from the kernel, which may run on another machine: bytes found again by their SHA-256."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import settings_message, vector_message
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError, PluginFailedError
from virtualrobot.files.resolver import Resolver, UnresolvedUriError, join_uri
from virtualrobot.scene.figures import Figure, styled
from virtualrobot.v1 import asset_pb2, nodes_pb2

_CHUNK_BYTES = 1024 * 1024
_NAME_NOTHING = (".stl", ".png", ".jpg", ".jpeg", ".gif", ".bmp", ".tga", ".tif", ".tiff", ".bin", ".webp")
_NAME_ALL_AT_ONCE = (".obj", ".mtl", ".dae", ".gltf", ".glb")
_SCENES = (".yaml", ".yml")
_MODELS = (".urdf", ".xacro", ".sdf", ".srdf", ".xml", *_SCENES)
_UNREADABLE = (MalformedFileError, MissingFileError, InvalidArgumentError, PluginFailedError)


@shown
@dataclass(frozen=True, slots=True)
class Upload:
    """A file and all that it names, now held by the kernel.

    Attributes:
        uri: the main file's name in `files`.
        files: SHA-256 by name; a name in a file counts from the name of that file.
        missing: files that are not on this machine, by their names in the file: the kernel may have it, or do without.
    """

    uri: str
    files: dict[str, str] = field(default_factory=dict)
    missing: dict[str, UnresolvedUriError] = field(default_factory=dict)

    def _messages(self) -> list[nodes_pb2.AssetFile]:
        """Return the files as messages."""
        return [nodes_pb2.AssetFile(uri=uri, sha256=sha256) for uri, sha256 in self.files.items()]


@checked
class Assets:
    """The kernel's store of files."""

    def __init__(self, services: Services) -> None:
        """Handle the store of one kernel."""
        self._services = services

    def upload(self, data: bytes) -> str:
        """Give the kernel a file's bytes; return their SHA-256. Bytes that it holds already are not sent."""
        sha256 = hashlib.sha256(data).hexdigest()
        if not self.find([sha256]):
            self._send(sha256, data)
        return sha256

    def download(self, sha256: str) -> bytes:
        """Take a file's bytes from the kernel."""
        request = asset_pb2.DownloadAssetRequest(sha256=sha256)
        stream = self._services.asset.DownloadAsset(request, timeout=LONG_TIMEOUT_SECONDS)
        return b"".join(response.chunk for response in stream)

    def find(self, sha256s: Iterable[str]) -> set[str]:
        """Return which of these files the kernel holds."""
        return set(self._services.asset.FindAssets(asset_pb2.FindAssetsRequest(sha256s=sha256s)).sha256s)

    def mesh(
        self,
        file: str | Path,
        *,
        scale: float | Sequence[float] = 1.0,
        color: str | ArrayLike | None = None,
        pose: PoseLike | None = None,
        roles: Sequence[str] = (),
    ) -> Figure:
        """Return a mesh file of this machine as a figure, with its materials and textures, all uploaded.

        `scale` is one factor or three, for x, y, z; a negative one mirrors. Other options as in `virtualrobot.box`.

        Example:
            >>> client.scene.add_object("table", client.assets.mesh("table.obj", scale=0.001))
        """
        upload = self.upload_with_references(file)
        factors = (scale,) * 3 if isinstance(scale, int | float) else tuple(scale)
        mesh = nodes_pb2.Mesh(
            uri=upload.uri,
            sha256=upload.files[upload.uri],
            scale=vector_message(factors, "the scale of a mesh"),
            files=[message for message in upload._messages() if message.uri != upload.uri],
        )
        return styled(nodes_pb2.Figure(mesh=mesh), color, pose, roles)

    def triangles(
        self,
        corners: ArrayLike,
        triangles: ArrayLike,
        *,
        color: str | ArrayLike | None = None,
        pose: PoseLike | None = None,
        roles: Sequence[str] = (),
    ) -> Figure:
        """Return a mesh of arrays as a figure, uploaded, such as ground from a height field.

        Args:
            corners: (n, 3) in meters.
            triangles: (m, 3), one at least: the numbers of their corners from 0, to the left around from outside.
            color: as in `virtualrobot.box`, like `pose` and `roles`.
            pose: `node_t_figure`, 4x4.
            roles: `visual`, `collision`; both without.

        Example:
            >>> ramp = client.assets.triangles([(0, 0, 0), (1, 0, 0), (1, 1, 0.2), (0, 1, 0.2)], [(0, 1, 2), (0, 2, 3)])
            >>> client.scene.add_object("ramp", ramp)
        """
        places, numbers = np.asarray(corners, dtype=float), np.asarray(triangles)
        if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
            raise InvalidArgumentError(f"corners are finite numbers of shape (n, 3), not of {places.shape}")
        if numbers.ndim != 2 or numbers.shape[1] != 3 or not len(numbers) or numbers.dtype.kind not in "iu":
            raise InvalidArgumentError(
                f"triangles are whole numbers of shape (m, 3), not {numbers.dtype} {numbers.shape}"
            )
        if (outside := (numbers < 0) | (numbers >= len(places))).any():
            row = int(np.nonzero(outside.any(axis=1))[0][0])
            raise InvalidArgumentError(f"triangle {row} has the corners {numbers[row].tolist()} of {len(places)}")
        mesh = np.zeros(len(numbers), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
        mesh["corners"] = places[numbers]
        sha256 = self.upload(bytes(80) + np.array(len(numbers), "<u4").tobytes() + mesh.tobytes())
        return styled(
            nodes_pb2.Figure(mesh=nodes_pb2.Mesh(uri=f"{sha256[:12]}.stl", sha256=sha256)), color, pose, roles
        )

    def upload_with_references(
        self,
        file: str | Path,
        packages: Mapping[str, str | Path] | None = None,
        settings: Mapping[str, object] | None = None,
        *,
        text: str | None = None,
    ) -> Upload:
        """Give the kernel a file of this machine and all files that it names, and those that these name.

        `file` is a path or a URI such as `package://pybullet_data/r2d2.urdf`; `packages` gives folders by package name,
        `settings` are those of the importer, since a file that is translated may name files by them. What a file names
        but is not here is left out and told in `missing`. With `text`, its content, `file` only names it.

        Raises:
            MissingFileError: when the file itself is not here.
            MalformedFileError: when the kernel cannot read the file.
        """
        resolver = Resolver(packages)
        if text is None:
            try:
                path = resolver.resolve(str(file))
            except UnresolvedUriError as error:
                raise MissingFileError(str(error), metadata={"tried": ", ".join(map(str, error.tried))}) from error
        else:
            path = Path(file).absolute()
        # A path is made absolute, so that a scene saved later names the same file.
        main = str(file) if "://" in str(file) else path.as_posix()
        upload = Upload(main)
        paths = {main: path}
        if text is None:
            self._send_all(upload, paths)
        else:
            upload.files[main] = self.upload(text.encode())
        asked = [main]
        while asked:
            named: dict[str, Path] = {}
            again: dict[str, None] = {}
            for referrer in asked:
                here = self._references(upload, paths[referrer], referrer, resolver, settings)
                new = {name: place for name, place in here.items() if name not in upload.files}
                named |= new
                again |= dict.fromkeys(name for name in new if _may_name_others(main, referrer, name))
                # What is translated may name more when it has these: a xacro file includes others, then names meshes.
                if new and _ending(referrer) not in _NAME_ALL_AT_ONCE:
                    again[referrer] = None
            self._send_all(upload, named)
            paths |= named
            asked = list(again)
        return upload

    def _references(
        self, upload: Upload, path: Path, referrer: str, resolver: Resolver, settings: Mapping[str, object] | None
    ) -> dict[str, Path]:
        """Return where the files are that one file names, by their joined names; note those that are not here."""
        request = asset_pb2.ListReferencesRequest(
            sha256=upload.files[referrer],
            uri=referrer,
            files=[] if _ending(referrer) in _NAME_ALL_AT_ONCE else upload._messages(),
            settings=settings_message(settings) if settings and referrer == upload.uri else None,
        )
        try:
            files = self._services.asset.ListReferences(request, timeout=LONG_TIMEOUT_SECONDS).files
        except _UNREADABLE:
            if referrer == upload.uri:
                raise
            # What reads the main file says what is wrong with this one, if it reads it at all.
            return {}
        here: dict[str, Path] = {}
        for file in files:
            try:
                here[join_uri(referrer, file.uri)] = resolver.resolve(file.uri, path, file.sha256)
            except UnresolvedUriError as error:
                upload.missing[file.uri] = error
        return here

    def _send_all(self, upload: Upload, paths: Mapping[str, Path]) -> None:
        """Upload files and note their SHA-256; ask once which of them the kernel has."""
        for name, path in paths.items():
            upload.files[name] = _hash_of(path)
        here = {upload.files[name]: path for name, path in paths.items()}
        for sha256 in here.keys() - self.find(here):
            self._send(sha256, here[sha256])

    def _send(self, sha256: str, source: bytes | Path) -> None:
        def requests() -> Iterator[asset_pb2.UploadAssetRequest]:
            yield asset_pb2.UploadAssetRequest(sha256=sha256)
            for chunk in _chunks(source):
                yield asset_pb2.UploadAssetRequest(chunk=chunk)

        self._services.asset.UploadAsset(requests(), timeout=LONG_TIMEOUT_SECONDS)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Assets of the kernel at {self._services.address}>"


def _may_name_others(main: str, referrer: str, name: str) -> bool:
    """Return whether to ask which files are named by `name`, which the file `referrer` has named.

    The models of a scene file are read for themselves. A model that another one names is a part of that one (an
    include, its parameters) and means nothing alone; what translates the whole tells what the part names.
    """
    if _ending(name) in _MODELS:
        return referrer == main and _ending(main) in _SCENES
    return _ending(name) not in _NAME_NOTHING


def _ending(name: str) -> str:
    return PurePosixPath(name).suffix.lower()


def _chunks(source: bytes | Path) -> Iterator[bytes]:
    if isinstance(source, bytes):
        yield from (source[start : start + _CHUNK_BYTES] for start in range(0, len(source), _CHUNK_BYTES))
        return
    with source.open("rb") as file:
        while chunk := file.read(_CHUNK_BYTES):
            yield chunk


def _hash_of(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise MissingFileError(f"{path} cannot be read: {error.strerror or error}") from error
