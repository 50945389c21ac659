"""The begin of a recording: which file, which format, which topics."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO, TypedDict

from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.recording import topics
from virtualrobot.recording.animation import RATE_HERTZ, AnimationOutput, glb_file
from virtualrobot.recording.recording import Output, Recording
from virtualrobot.recording.run_page import page_file, player
from virtualrobot.recording.table_output import CsvFile, TableOutput
from virtualrobot.v1 import kernel_pb2, robot_pb2, sensor_pb2, signal_pb2

ENDINGS = (".mcap", ".csv", ".parquet", ".glb", ".html")
ANIMATIONS = (".glb", ".html")
PICTURES = ("raw", "png")
EXTRAS = {".mcap": "record", ".parquet": "parquet"}


class RecordingOptions(TypedDict, total=False):
    """Options of recordings.

    Attributes:
        topics: names of topics, or patterns such as `/robots/*`; in tables those of columns too, such as `arm/*`. All
            by default.
        rate: the most states of robots and of the scene a second; by default each tick that the kernel tells, of an
            animated scene 60. Signals and readings are recorded however often they come.
        overwrite: whether a file that is there is replaced; else it is refused.
        pictures: colours of cameras in an MCAP file: `raw` (the default), or `png`, which is smaller and takes longer.
    """

    topics: Iterable[str]
    rate: float | None
    overwrite: bool
    pictures: str


def start(
    services: Services,
    path: str | Path,
    duration: float | None,
    options: RecordingOptions,
    *,
    complete: bool = False,
) -> Recording:
    """Begin a recording; the arguments are those of `Client.start_recording`.

    One that is `complete` takes topics that come later; a CSV file has columns for them, and is readable at its end.
    """
    path = checked_path(path, options)
    ending = path.suffix.lower()
    for name, value in (("duration", duration), ("rate", rate := options.get("rate"))):
        if value is not None and not 0.0 < value < float("inf"):
            raise InvalidArgumentError(f"{name} is above 0, not {value:g}")
    pictures = options.get("pictures") or PICTURES[0]
    if pictures not in PICTURES:
        raise InvalidArgumentError(f"pictures are {' or '.join(PICTURES)}, not {pictures!r}")
    wanted = tuple(options.get("topics") or ())
    if wanted and ending in ANIMATIONS:
        raise InvalidArgumentError(f"{ending} has the scene and how it moves, and no topics: leave topics away")
    selection = topics.Selection(wanted)
    info = services.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    about = {"version": info.version, "api_version": info.api_version}
    try:
        if ending == ".mcap":
            from virtualrobot.recording.mcap_output import McapOutput
        elif ending == ".parquet":
            from virtualrobot.recording.parquet_file import ParquetFile
    except ImportError as error:
        package = (error.name or "").partition(".")[0]
        raise WrongStateError(
            f"{ending} needs the package {package}: pip install 'virtualrobot[{EXTRAS[ending]}]'"
        ) from None
    table = TableOutput(services, selection) if ending in (".csv", ".parquet") else None
    if not complete:
        selection.check(_topics(services) if table is None else table.known)
    page = player() if ending == ".html" else ""
    stream = _opened(path, options.get("overwrite") or False)
    try:
        if ending in ANIMATIONS:
            output: Output = AnimationOutput(services, page_file(stream, page) if page else glb_file(stream))
        elif table is None:
            output = McapOutput(stream, services, selection, about, pictures == "png")
        else:
            csv = ending == ".csv"
            table.begin(
                lambda columns: CsvFile(stream, columns) if csv else ParquetFile(stream, columns, about),
                grows=complete or not csv,
            )
            output = table
        return Recording(services, path, stream, output, rate=rate or usual_rate(path), duration=duration)
    except BaseException:
        stream.close()
        raise


def usual_rate(path: str | Path) -> float | None:
    """Return the states a second of a recording whose rate is not given; None: each tick."""
    return RATE_HERTZ if Path(path).suffix.lower() in ANIMATIONS else None


def checked_path(path: str | Path, options: RecordingOptions) -> Path:
    """Return the path of a recording.

    Raises:
        InvalidArgumentError: when its ending is none of theirs, or it is there and shall not be overwritten.
    """
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        endings = f"{', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}"
        raise InvalidArgumentError(f"{path} is no recording; let its name end with {endings}")
    if path.exists() and not options.get("overwrite"):
        raise InvalidArgumentError(f"{path} is there already: choose another name, or overwrite it")
    return path


def _topics(services: Services) -> list[str]:
    """Return the topics that there are now; of sensors all that one of their kind may have."""
    states = services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()).robots
    signals = services.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals
    sensors = services.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors
    return [
        *topics.OF_WORLD,
        *(topic for state in states for topic in topics.of_robot(state.name)),
        *(topics.signal(one.name) for one in signals),
        *(topics.sensor(one.name, told) for one in sensors for told in topics.CONTENTS.get(one.kind, ("reading",))),
    ]


def _opened(path: Path, overwrite: bool) -> BinaryIO:
    try:
        return path.open("wb" if overwrite else "xb")
    except OSError as error:
        raise InvalidArgumentError(f"{path} cannot be written: {error.strerror or error}") from error
