"""Films: pictures of equal steps of simulation time in one file, .mp4 or .gif."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.view.pictures import Picture, Recording

ENDINGS = (".mp4", ".gif")
LEAST_RATE, GREATEST_RATE = 0.01, 1000.0
"""Range of rates of a film, in pictures per second."""
GREATEST_GIF_RATE = 100.0
"""A GIF counts time in hundredths of a second."""
Told = Callable[[Picture], None]


class FilmFile:
    """A film that is being written; closing it makes the file whole, whatever has happened."""

    def __init__(self, path: str | Path, rate: float) -> None:
        """Write `rate` pictures a second to a file.

        Raises:
            InvalidArgumentError: when the file's name ends with neither .mp4 nor .gif, when its folder is not there, or
                it cannot have that rate.
            WrongStateError: when the package for films is not installed.
        """
        self.path = _checked(path, rate)
        self.count = 0
        self.rate = rate
        self._av = _library()
        self._rate = Fraction(rate).limit_denominator(1000)
        self._container: Any = None
        self._stream: Any = None
        self._palette: Any = None

    def add(self, pixels: NDArray[np.uint8]) -> None:
        """Add a picture (h, w, 3), as large as the first one; an odd last row or column is left out in .mp4.

        Raises InvalidArgumentError for an .mp4 of less than 2 pixels.
        """
        stream = self._stream
        if stream is None:
            stream = self._stream = self._begun(pixels.shape[1], pixels.shape[0])
        rows, columns = stream.height, stream.width
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels[:rows, :columns]), format="rgb24")
        frame.pts, frame.time_base = self.count, 1 / self._rate
        self.count += 1
        if self._palette is not None:
            self._palette.push(frame)
            frame = self._palette.pull()
        self._container.mux(stream.encode(frame))

    def close(self) -> None:
        """Write what is left; a film without pictures is no file."""
        if self._stream is not None:
            self._container.mux(self._stream.encode())
            self._container.close()
            self._stream = None

    def __enter__(self) -> FilmFile:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def _begun(self, width: int, height: int) -> Any:  # noqa: ANN401 the package may be missing
        """Open the file, and return its stream of pictures of this size."""
        if self.path.suffix.lower() == ".mp4" and min(width, height) < 2:
            raise InvalidArgumentError(f"an .mp4 is at least 2 pixels wide and high, not {width} x {height}")
        self._container = self._av.open(str(self.path), "w", options=_container_options(self.path))
        if self.path.suffix.lower() == ".gif":
            stream = self._container.add_stream("gif", rate=self._rate)
            stream.pix_fmt = "pal8"
            self._palette = _palette(self._av, width, height, self._rate)
        else:
            known = "libx264" in self._av.codecs_available
            stream = self._container.add_stream("libx264" if known else "mpeg4", rate=self._rate)
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": "18"} if known else {"qscale": "3"}
            width, height = width - width % 2, height - height % 2
        stream.width, stream.height = width, height
        stream.codec_context.time_base = 1 / self._rate
        return stream

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<FilmFile {str(self.path)!r}: {self.count} pictures, {self.rate:g} a second>"


class FilmThread:
    """Writes a film in a thread of its own while the program goes on; `finish` or `cancel` ends it.

    As a context manager it is finished at the end of its block, and cancelled where that is left by an exception.
    """

    def __init__(self, file: FilmFile, pictures: Recording, now: Callable[[], float], told: Told | None = None) -> None:
        """Begin; `pictures` are of the format `raw`, `now` tells the simulation time, `told` gets each picture."""
        self._file, self._pictures, self._now, self._told = file, pictures, now, told
        self._period = 1.0 / file.rate
        self._drawn = -math.inf
        self._fault: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="film")
        self._thread.start()

    @property
    def ended(self) -> bool:
        """True once no picture comes any more; `finish` tells why."""
        return not self._thread.is_alive()

    def finish(self) -> int:
        """Wait until all is drawn that has happened so far, and return how many pictures there are.

        Raises what ended the film before.
        """
        until = self._now()
        try:
            # Waited for in small steps: Ctrl-C would not get through on Windows.
            # Times are rounded: the last picture is due where nearly a period has gone.
            while self._thread.is_alive() and until - self._drawn > 0.999 * self._period:
                self._thread.join(0.1)
        finally:
            self.cancel()
        if self._fault is not None:
            raise self._fault
        return self._file.count

    def cancel(self) -> None:
        """End it with the pictures that are drawn."""
        self._pictures.cancel()
        self._thread.join()

    def __enter__(self) -> FilmThread:
        """Return itself."""
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        """Finish or cancel it."""
        if error is None:
            self.finish()
        else:
            self.cancel()

    def _run(self) -> None:
        try:
            with self._file:
                for picture in self._pictures:
                    self._file.add(picture.pixels)
                    self._drawn = picture.simulation_time
                    if self._told is not None:
                        self._told(picture)
        except Exception as error:  # told to who waits for the film
            self._fault = error

    def __repr__(self) -> str:
        """Return a line for people."""
        state = "being filmed" if self._thread.is_alive() else "ended"
        return f"<FilmThread {str(self._file.path)!r}: {self._file.count} pictures, {state}>"


def write(pictures: Iterable[Picture], file: FilmFile, told: Told | None = None) -> int:
    """Write pictures of the format `raw`, and return how many there are."""
    for picture in pictures:
        file.add(picture.pixels)
        if told is not None:
            told(picture)
    return file.count


def _checked(path: str | Path, rate: float) -> Path:
    """Return the path of a film of so many pictures a second, or raise InvalidArgumentError."""
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise InvalidArgumentError(f"{path} is no film; let its name end with {' or '.join(ENDINGS)}")
    most = GREATEST_GIF_RATE if ending == ".gif" else GREATEST_RATE
    if not LEAST_RATE <= rate <= most:
        raise InvalidArgumentError(
            f"a film of the kind {ending} has {LEAST_RATE:g} to {most:g} pictures a second, not {rate:g}"
        )
    # The file is opened with the first picture, which in a thread is told of at the film's end only.
    if not Path(path).parent.is_dir():
        raise InvalidArgumentError(f"{path} cannot be written: there is no folder {Path(path).parent}")
    return Path(path)


def _library() -> Any:  # noqa: ANN401 a module that may be missing
    try:
        import av
    except ImportError:
        raise WrongStateError("films need the package av: pip install 'virtualrobot[video]'") from None
    return av


def _container_options(path: Path) -> dict[str, str]:
    """Return options that let a browser show an .mp4 before it has all of it."""
    return {"movflags": "faststart"} if path.suffix.lower() == ".mp4" else {}


def _palette(av: Any, width: int, height: int, rate: Fraction) -> Any:  # noqa: ANN401 as above
    """Return what chooses the 256 colours of each picture of a GIF: pictures go in and come out."""
    graph = av.filter.Graph()
    source = graph.add_buffer(width=width, height=height, format="rgb24", time_base=1 / rate)
    split, use = graph.add("split"), graph.add("paletteuse", "new=1")
    palette = graph.add("palettegen", "stats_mode=single")
    sink = graph.add("buffersink")
    source.link_to(split)
    split.link_to(palette, 0, 0)
    split.link_to(use, 1, 0)
    palette.link_to(use, 0, 1)
    use.link_to(sink)
    graph.configure()
    return graph
