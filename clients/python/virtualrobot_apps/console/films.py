"""Films that the console takes for its pages, as `virtualrobot record film.mp4` takes them.

They are files of the console's, which pages download, until they are removed, newer ones take their room or the console
ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Lock, Thread
from typing import Any

from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, VirtualRobotError, WrongStateError
from virtualrobot.view.pictures import Picture

from virtualrobot_apps.console.numbers import numbers

Connect = Callable[[str], Client]
"""Gives a client of the kernel with a token."""

RATE = 25.0
"""Pictures a second of simulation time."""
MOST_TAKEN = 2
"""Films that are taken at a time: the kernel draws two pictures at once."""
MOST_KEPT = 8
"""Films that are kept; of more the oldest go."""
MOST_SECONDS = 600.0
"""Simulation time (s) after which a film ends by itself, whoever has forgotten it."""

LEAST_PIXELS, MOST_PIXELS = 2, 4096
"""Width and height of films, by the codec and by the kernel."""

_LOOKED_SECONDS = 0.1

Camera = str | tuple[Sequence[float], Sequence[float], float] | None


class Films:
    """The films of one console. Its methods wait for the kernel, so that they are called in threads."""

    def __init__(self, connect: Connect) -> None:
        """Keep them in a folder of their own, which goes with the console."""
        self._connect = connect
        self._folder: TemporaryDirectory[str] | None = None
        self._lock = Lock()
        self._films: dict[int, _Film] = {}
        self._count = 0

    def state(self) -> list[dict[str, Any]]:
        """Return what there is, the newest first, as pages are told it."""
        return [film.state() for film in reversed(list(self._films.values()))]

    def start(self, token: str, camera: Camera, size: tuple[int, int] | None) -> None:
        """Begin a film of the view from somewhere, or of a camera of the scene.

        Raises WrongStateError where as many are taken as can be, or the package for films is missing, and what the
        kernel says of the camera or the size.
        """
        with self._lock:
            if sum(not film.stopping.is_set() for film in self._films.values()) >= MOST_TAKEN:
                raise WrongStateError(f"{MOST_TAKEN} films are being taken already: stop one of them")
            if self._folder is None:
                self._folder = TemporaryDirectory(prefix="virtualrobot-films-")
            self._count += 1
            name = f"film-{self._count}.mp4"
            film = _Film(self._connect, token, Path(self._folder.name) / name, camera, size)
            self._films[self._count] = film
            over = [number for number, one in self._films.items() if one.ended]
            for number in over[: max(0, len(self._films) - MOST_KEPT)]:
                self._drop(number)

    def stop(self, name: str) -> None:
        """Let a film end with what has happened so far, which may still have to be drawn."""
        self._film(name)[1].stopping.set()

    def remove(self, name: str) -> None:
        """Drop a film; one that is taken or drawn ends at once."""
        with self._lock:
            self._drop(self._film(name)[0])

    def path(self, name: str) -> Path:
        """Return the file of a film that is whole; raises UnknownNameError, or WrongStateError for one that isn't."""
        film = self._film(name)[1]
        if not film.ended:
            raise WrongStateError(f"{name} is not whole yet")
        if film.fault or not film.path.exists():
            raise WrongStateError(film.fault or f"{name} has no pictures")
        return film.path

    def close(self) -> None:
        """End all, and drop the files."""
        with self._lock:
            for number in list(self._films):
                self._drop(number)
            if self._folder is not None:
                self._folder.cleanup()
                self._folder = None

    def _drop(self, number: int) -> None:
        self._films.pop(number).drop()

    def _film(self, name: str) -> tuple[int, _Film]:
        for number, film in list(self._films.items()):
            if film.path.name == name:
                return number, film
        raise UnknownNameError(f"the console has no film {name!r}", code="NOT_FOUND")


class _Film:
    """One film, taken by a thread of its own; `fault` says why it has ended by itself."""

    def __init__(self, connect: Connect, token: str, path: Path, camera: Camera, size: tuple[int, int] | None) -> None:
        """Begin, and return when the first picture can be drawn; raises why that could not be."""
        self.path, self.fault, self.stopping = path, "", Event()
        self._connect, self._token, self._camera, self._size = connect, token, camera, size
        self._dropping, self._begun = Event(), Future[None]()
        self._pictures = self._behind = 0
        self._thread = Thread(target=self._run, name=path.name, daemon=True)
        self._thread.start()
        self._begun.result()

    @property
    def ended(self) -> bool:
        """True once the file is whole, or there is none."""
        return not self._thread.is_alive()

    def state(self) -> dict[str, Any]:
        """Return how it is, as pages are told it: `seconds` that are drawn, pictures `behind`, `bytes` of the file."""
        ended = self.ended
        return {
            "name": self.path.name,
            "camera": self._camera if isinstance(self._camera, str) else "",
            "phase": "failed" if self.fault else "whole" if ended else "drawn" if self.stopping.is_set() else "taken",
            "seconds": self._pictures / RATE,
            "behind": self._behind,
            "bytes": self.path.stat().st_size if ended and self.path.exists() else 0,
            "fault": self.fault,
        }

    def drop(self) -> None:
        """End at once, and remove the file."""
        self._dropping.set()
        self.stopping.set()
        self._thread.join()
        self.path.unlink(missing_ok=True)

    def _run(self) -> None:
        try:
            with self._connect(self._token) as client:
                client.view.capture(self._camera, size=self._size, format="raw")  # says what is wrong with them
                film = client.view.start_film(self.path, self._camera, size=self._size, rate=RATE, told=self._told)
                self._begun.set_result(None)
                while not self.stopping.wait(_LOOKED_SECONDS) and not film.ended:
                    pass
                self.stopping.set()
                if self._dropping.is_set():
                    film.cancel()
                else:
                    film.finish()
        except Exception as error:  # told to who began it, or to pages
            self.fault = str(error) if isinstance(error, VirtualRobotError) else f"{type(error).__name__}: {error}"
            self.stopping.set()
            if not self._begun.done():
                self._begun.set_exception(error)

    def _told(self, picture: Picture) -> None:
        self._pictures, self._behind = picture.number + 1, picture.behind
        if self._pictures + self._behind >= MOST_SECONDS * RATE:
            self.stopping.set()


def camera_of(said: object) -> Camera:
    """Return the camera that a page names: a node, or `{position, target, field}` in meters and radians, or none."""
    if said is None or isinstance(said, str):
        return said or None
    if isinstance(said, dict) and said.keys() == {"position", "target", "field"}:
        position, target = (numbers(said[name], name, 3) for name in ("position", "target"))
        (field,) = numbers([said["field"]], "field", 1)
        return position, target, field
    raise InvalidArgumentError(f"a camera is the name of a node, or position, target and field, not {said!r:.80}")


def size_of(said: object) -> tuple[int, int] | None:
    """Return the size in pixels that a page wants; None is that of the camera."""
    if said is None:
        return None
    size = [int(one) for one in numbers(said, "size", 2)]
    if not all(LEAST_PIXELS <= one <= MOST_PIXELS for one in size):
        raise InvalidArgumentError(f"a film is {LEAST_PIXELS} to {MOST_PIXELS} pixels wide and high, not {said}")
    return size[0], size[1]
