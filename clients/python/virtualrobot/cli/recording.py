"""`virtualrobot record`: films, and recordings of what a kernel tells."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.pictures import camera_of, camera_options, plain_option

if TYPE_CHECKING:
    from virtualrobot.recording.recording import Recorded, Recording
    from virtualrobot.recording.start import RecordingOptions
    from virtualrobot.view.pictures import Picture

DEFAULT_RATE = 25.0
ABOVE_ZERO = FiniteRange(0.0, min_open=True)

RECORDINGS = (".mcap", ".csv", ".parquet", ".glb", ".html")
_FILMS = (".mp4", ".gif")
_FILM = ("fps", "camera", "eye", "target_point", "size", "plain")
_DATA = ("topics", "rate", "png", "overwrite")
_OPTIONS = {"eye": "--from", "target_point": "--at", "begin": "--from", "end": "--to"}


def option_of(name: str) -> str:
    """Return the option that an argument is given by."""
    return _OPTIONS.get(name, f"--{name}")


def data_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of recordings."""
    for option in (
        click.option("--overwrite", is_flag=True, help="Recordings: replace a file that is there."),
        click.option("--png", is_flag=True, help="Recordings: colours of cameras as PNG."),
        click.option(
            "--rate", type=ABOVE_ZERO, help="Recordings: the most states a second [each tick; .glb, .html: 60]."
        ),
        click.option(
            "--topics",
            multiple=True,
            metavar="PATTERN",
            help="Recordings: only these, such as '/robots/*'; may be given again.",
        ),
    ):
        function = option(function)
    return function


def run_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of recordings of a run that is over."""
    times = FiniteRange(0.0)
    to = click.option(
        "--to", "end", type=times, metavar="S", help="Recordings: end at this simulation time [the last]."
    )
    begin = click.option("--from", "begin", type=times, metavar="S", help="Recordings: begin there [the first].")
    return begin(to(data_options(function)))


@click.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--seconds", type=ABOVE_ZERO, help="Of simulation time [until Ctrl-C].")
@data_options
@click.option("--fps", type=ABOVE_ZERO, help=f"Films: pictures a second [{DEFAULT_RATE:g}].")
@camera_options
@plain_option
@target_options
def record(target: Target, output: Path, seconds: float | None, **options: Any) -> None:  # noqa: ANN401 those above
    r"""Record what happens to OUTPUT, until so many seconds of simulation time have gone by, or Ctrl-C.

    \b
    .mcap           joints, transforms, scene, sensors, signals, motions: for Foxglove and PlotJuggler
    .csv, .parquet  a table of joints, tool centre points and signals
    .glb            the scene and how it moved, for viewers of glTF and modellers
    .html           the same as a page that plays in any browser, without a kernel
    .mp4, .gif      a film; no picture is left out, however long each takes

    Ctrl-C leaves a whole file. --topics, --rate, --png and --overwrite are for recordings of data, --fps and what
    follows it for films.
    """
    film = output.suffix.lower() in _FILMS
    for name in _DATA if film else _FILM:
        if options[name]:
            raise click.UsageError(f"{option_of(name)} is not for {output.suffix or 'names without an ending'}")
    (_film if film else _data)(target, output, seconds, options)


def _film(target: Target, output: Path, seconds: float | None, options: dict[str, Any]) -> None:
    fps = options["fps"] or DEFAULT_RATE
    progress = FilmProgress((seconds or 0.0) * fps)
    with target.connect() as client:
        where = camera_of(options["camera"], options["eye"], options["target_point"])
        try:
            client.view.film(
                *(output, where),
                duration=seconds or None,
                size=options["size"],
                plain=options["plain"],
                rate=fps,
                told=progress.show,
            )
        except KeyboardInterrupt:
            if not progress.count:
                raise
    progress.end(output, fps)


def _data(target: Target, output: Path, seconds: float | None, options: dict[str, Any]) -> None:
    with target.connect() as client:
        recording = client.start_recording(output, duration=seconds, **_chosen(options))
        try:
            while not recording.wait(0.25):
                _show(recording, seconds)
        except KeyboardInterrupt:
            pass  # the file is made whole with what there is
        recorded = recording.finish()
    _tell(recorded)


def export_run(folder: str, output: Path, options: dict[str, Any]) -> None:
    """Record a run that is over; Ctrl-C leaves a whole file."""
    from virtualrobot.recording import export

    begin, end = options["begin"], options["end"]
    _tell(export.export_run(folder, output, begin=begin, end=end, told=_show, **_chosen(options)))


def _chosen(options: dict[str, Any]) -> RecordingOptions:
    return {
        "topics": options["topics"],
        "rate": options["rate"],
        "overwrite": options["overwrite"],
        "pictures": "png" if options["png"] else "raw",
    }


def _show(recording: Recording, seconds: float | None) -> None:
    if sys.stderr.isatty():
        of = f" of {seconds:g}" if seconds else ""
        click.echo(f"\r\x1b[K{recording.simulation_time:.1f}{of} s", nl=False, err=True)


def _tell(recorded: Recorded) -> None:
    if sys.stderr.isatty():
        click.echo("\r\x1b[K", nl=False, err=True)
    for line in _told(recorded):
        click.echo(line)
    for line in _left_out(recorded):
        click.echo(line, err=True)


def _told(recorded: Recorded) -> list[str]:
    from virtualrobot.tables import aligned

    span = f"{recorded.end - recorded.start:.3f} s from {recorded.start:.3f} s on"
    size = f"{recorded.path.stat().st_size / 1e6:.2f} MB"
    return [
        f"{recorded.path}: {span}, {size}",
        *(
            f"  {line}"
            for line in aligned([[name, str(count)] for name, count in sorted(recorded.counts.items())], left=1)
        ),
    ]


def _left_out(recorded: Recorded) -> list[str]:
    said = [f"it ended early: {recorded.end_reason}"] if recorded.end_reason else []
    if recorded.missed_ticks:
        said.append(f"{recorded.missed_ticks} ticks in which robots moved were not told: kernel or recorder were busy")
    if recorded.missed_readings:
        said.append(f"{recorded.missed_readings} readings of sensors were not told")
    return [*said, *recorded.notes]


class FilmProgress:
    """A line that tells how far a film is; on a terminal it is written over itself."""

    def __init__(self, whole: float = 0.0) -> None:
        """Count to so many pictures; 0 where nobody knows."""
        self._whole = round(whole)
        self.count = 0
        self._behind = 0

    def show(self, picture: Picture) -> None:
        """Tell of one more picture."""
        self.count, self._behind = picture.number + 1, picture.behind
        if sys.stderr.isatty():
            of = f" of {self._whole}" if self._whole else ""
            behind = f", {self._behind} more have happened" if self._behind else ""
            click.echo(f"\r\x1b[Kpicture {self.count}{of}{behind}", nl=False, err=True)

    def end(self, output: Path, rate: float) -> None:
        """Tell what the film is."""
        if sys.stderr.isatty():
            click.echo("\r\x1b[K", nl=False, err=True)
        click.echo(f"{output}: {self.count} pictures, {self.count / rate:.2f} s")
        if self._behind:
            click.echo(f"{self._behind} more have happened and were not drawn", err=True)
