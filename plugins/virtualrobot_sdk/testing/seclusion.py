"""Watches which files, hosts and processes Python code touches: an importer gets all that it reads from its caller."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from types import FrameType, TracebackType

_OUTSIDE = (
    *("socket.connect", "socket.bind", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto"),
    *("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.startfile"),
)
_FILES = (
    *("open", "os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate"),
    *("os.listdir", "os.scandir", "shutil.copyfile", "shutil.move", "shutil.rmtree", "glob.glob"),
)
_IN_A_FOLDER = ("os.remove", "os.mkdir", "os.rmdir")
"""Events that end with the descriptor of the folder that the name is in, or -1."""
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CODE = (".py", ".pyc", ".so", ".pyd", ".dll")
_MOST = 20
"""Largest number of different events that are kept."""


class Seclusion:
    """Owns an audit hook (PEP 578) that notes, and refuses, what is touched inside its `with` block.

    What Python and installed packages read of their own files is let through, and whatever happens while a module is
    imported. Files in the temporary folder and processes are noted as such and let through, since some converters need
    both. Native code is not seen.
    """

    def __init__(self) -> None:
        """Install the hook; there is no way to take one away, so it rests outside of `with`."""
        self.events: list[str] = []
        self._watching = False
        self._installed = _real(sys.prefix, sys.base_prefix, sys.exec_prefix, os.devnull, "/dev/urandom")
        self._modules = _real(*sys.path)
        self._scratch = os.path.realpath(tempfile.gettempdir())
        sys.addaudithook(self._heard)

    def __enter__(self) -> None:
        """Watch."""
        self._watching = True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Rest."""
        self._watching = False

    def _heard(self, event: str, arguments: tuple[object, ...]) -> None:
        if not self._watching or (event not in _FILES and event not in _OUTSIDE):
            return
        self._watching = False  # what is asked below is not the component's
        try:
            said, refused = self._judged(event, arguments)
            if said and not _importing(sys._getframe(1)):
                if said not in self.events and len(self.events) < _MOST:
                    self.events.append(said)
                if refused:
                    raise PermissionError(f"an importer may not do this: {said}")
        finally:
            self._watching = True

    def _judged(self, event: str, arguments: tuple[object, ...]) -> tuple[str, bool]:
        """Return what to say of an event, "" for one that is all right, and whether it must not happen."""
        if event in _OUTSIDE:
            is_network = event.startswith("socket.")
            return f"{event} {_short(arguments)}" if is_network else f"process: {_short(arguments)}", is_network
        named = arguments[0] if arguments else None
        if not isinstance(named, str | bytes | os.PathLike):
            return "", False  # a descriptor that is open already
        folder = arguments[-1] if event in _IN_A_FOLDER else -1
        path = os.path.realpath(os.path.join(_path_of(folder), os.fsdecode(named)))
        writes = event not in ("open", "os.listdir", "os.scandir", "glob.glob") or (
            event == "open" and isinstance(arguments[2], int) and bool(arguments[2] & _WRITING)
        )
        if not writes and self._is_code(path, event):
            return "", False
        if _below(path, self._scratch):
            return f"scratch: {Path(path).name}", False
        return f"{'writes' if writes else 'reads'} {path}", True

    def _is_code(self, path: str, event: str) -> bool:
        """Return whether a file is of Python's, or of a package that can be imported."""
        if any(_below(path, place) for place in self._installed):
            return True
        if not any(_below(path, place) for place in self._modules):
            return False
        of_a_package = os.path.exists(os.path.join(os.path.dirname(path), "__init__.py"))
        return event != "open" or path.endswith(_CODE) or of_a_package


def _real(*places: str) -> tuple[str, ...]:
    return tuple(os.path.realpath(place) for place in places if place)


def _path_of(folder: object) -> str:
    """Return the path of an open folder, "" where there is none or the system does not tell."""
    link = f"/proc/self/fd/{folder}"
    return os.readlink(link) if isinstance(folder, int) and folder >= 0 and os.path.exists(link) else ""


def _below(path: str, place: str) -> bool:
    return path == place or path.startswith(place.rstrip(os.sep) + os.sep)


def _importing(frame: FrameType | None) -> bool:
    """Return whether a module is being imported: libraries look for their settings then."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _short(arguments: tuple[object, ...]) -> str:
    text = " ".join(str(one) for one in arguments if isinstance(one, str | bytes | tuple | list | int))
    return text[:100]
