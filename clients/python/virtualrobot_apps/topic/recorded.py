"""Recorded files as rows of numbers: tables (.csv, .parquet), and of .mcap joints, tool centre points and signals."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.topic.curves import Curve, of_numbers

_POSE = ("x", "y", "z")
Cell = float | bool | str


@dataclass(frozen=True, slots=True)
class Row:
    """Changes at a time (s of simulation time): values by the names of the columns of a table."""

    time: float
    cells: Mapping[str, Cell]


def rows(path: Path) -> Iterator[Row]:
    """Yield the rows of a recorded file in order of time.

    Columns are called as in a table: `arm/joint_1/position`, `arm/tcp/x`, `signals/gripper`.

    Raises:
        InvalidArgumentError: when it is none, or is damaged.
        WrongStateError: when the package is missing that reads it.
    """
    readers = {".csv": _csv, ".parquet": _parquet, ".mcap": _mcap}
    if path.suffix.lower() not in readers:
        raise InvalidArgumentError(f"{path} is no recording; they end with .csv, .parquet or .mcap")
    if not path.is_file():
        raise InvalidArgumentError(f"there is no file {path}")
    try:
        yield from readers[path.suffix.lower()](path)
    except ImportError as error:
        extra = "parquet" if path.suffix.lower() == ".parquet" else "record"
        raise WrongStateError(f"{path.suffix} needs more: pip install 'virtualrobot[{extra}]'") from error
    except (ValueError, LookupError, OSError, csv.Error) as error:
        raise InvalidArgumentError(f"{path} cannot be read as a recording: {error}") from error


def curves(path: Path) -> dict[str, Curve]:
    """Return the numbers of a recorded file over time, with the speeds of what has x and y; raises as `rows` does."""
    cells = ((name, row.time, value) for row in rows(path) for name, value in row.cells.items())
    return of_numbers(((name, time, float(value)) for name, time, value in cells if not isinstance(value, str)), "/")


def _csv(path: Path) -> Iterator[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.reader(file)
        names = [name.partition(" [")[0] for name in next(lines, [])]
        if names[:1] != ["time"]:
            raise ValueError("its first column is not the time")
        for line in filter(None, lines):
            cells = {name: _cell(text) for name, text in zip(names[2:], line[2:], strict=False) if text}
            yield Row(float(line[0]), cells)


def _cell(text: str) -> Cell:
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def _parquet(path: Path) -> Iterator[Row]:
    from pyarrow import parquet

    for batch in parquet.ParquetFile(path).iter_batches():
        for one in batch.to_pylist():
            cells = {name: value for name, value in one.items() if value is not None and name not in ("time", "tick")}
            yield Row(one["time"], cells)


def _mcap(path: Path) -> Iterator[Row]:
    from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
    from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
    from google.protobuf.message import DecodeError
    from mcap.exceptions import McapError
    from mcap.reader import make_reader
    from virtualrobot.v1.signal_pb2 import Signal

    types: dict[str, Any] = {"foxglove.JointStates": JointStates, "foxglove.PoseInFrame": PoseInFrame}
    types["virtualrobot.v1.Signal"] = Signal
    with path.open("rb") as file:
        try:
            for schema, channel, message in make_reader(file).iter_messages():
                if schema is not None and schema.name in types:
                    cells = _of_message(channel.topic, types[schema.name].FromString(message.data))
                    yield Row(message.log_time / 1e9, cells)
        except (McapError, DecodeError) as error:
            raise ValueError(error) from error


def _of_message(topic: str, message: Any) -> dict[str, Cell]:  # noqa: ANN401 one of three kinds
    parts = topic.strip("/").split("/")
    if parts[0] == "signals":
        kind = message.value.WhichOneof("kind")
        return {} if kind in (None, "group") else {topic.strip("/"): getattr(message.value, kind)}
    robot = "/".join(parts[1:-1])
    if parts[-1] == "tcp":
        return {f"{robot}/tcp/{axis}": getattr(message.pose.position, axis) for axis in _POSE}
    if parts[-1] != "joint_states":
        return {}
    found: dict[str, Cell] = {}
    for joint in message.joints:
        found[f"{robot}/{joint.name}/position"] = joint.position
        found[f"{robot}/{joint.name}/velocity"] = joint.velocity
    return found
