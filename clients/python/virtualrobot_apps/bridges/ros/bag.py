"""Bags as lines of JSON, for programs that can't read them: `python -m virtualrobot_apps.bridges.ros.bag FILE`.

The first line tells topics, times and types; with `--topic` a line follows for each message. ROS 1 (.bag), ROS 2
(a folder, .mcap, .db3).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import click
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection

from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.types import ARRAY, BASE, MESSAGE, NO_FIELD, STORE, Description
from virtualrobot_apps.bridges.ros.messages.values import to_plain


@click.command()
@click.argument("file", type=click.Path(path_type=Path, exists=True))
@click.option("--topic", "topics", multiple=True, help="Tell the messages of this one, too; may be given again.")
@click.option("--start", type=float, default=float("-inf"), help="From this time on (s).")
@click.option("--end", type=float, default=float("inf"), help="Up to this time (s).")
def main(file: Path, topics: tuple[str, ...], start: float, end: float) -> None:
    """Tell what a bag holds."""
    try:
        with AnyReader([file], default_typestore=STORE) as reader:
            known = {one.topic for one in reader.connections}
            if missing := [one for one in topics if one not in known]:
                raise click.UsageError(f"{file} has no topic {missing[0]}; it has {', '.join(sorted(known))}")
            click.echo(json.dumps(_head(reader)))
            chosen = [one for one in reader.connections if one.topic in topics]
            for line in _messages(reader, chosen, start, end):
                click.echo(line)
    except click.ClickException:
        raise
    except Exception as error:  # of a damaged bag rosbags raises whatever it likes
        raise click.ClickException(f"{file} can't be read as a bag: {why(error)}") from error


def why(error: Exception) -> str:
    """Return in a line why rosbags can't read a bag."""
    if str(error) == "Profile is not ros2.":
        return "it is not of ROS 2; recordings of `virtualrobot record` are for `virtualrobot topic play`"
    return " ".join(f"{error or type(error).__name__}".split())[:200]  # some quote whole definitions of messages


def _head(reader: AnyReader) -> dict[str, Any]:
    defined = reader.typestore.fielddefs
    types = {one.msgtype for one in reader.connections}
    return {
        "first": reader.start_time / 1e9,
        "last": reader.end_time / 1e9,
        "topics": [
            {"topic": name, "type": one.msgtype or "", "count": one.msgcount}
            for name, one in sorted(reader.topics.items())
        ],
        "types": [{"type": type, "typedefs": list(_typedefs(type, defined))} for type in sorted(types)],
    }


def _messages(reader: AnyReader, chosen: list[Connection], start: float, end: float) -> Iterator[str]:
    for connection, time, data in reader.messages(connections=chosen) if chosen else ():
        if start <= time / 1e9 <= end:
            message = plain(reader.deserialize(data, connection.msgtype))
            yield json.dumps({"topic": connection.topic, "time": time / 1e9, "msg": message}, allow_nan=False)


def plain(value: RosValue) -> Any:  # noqa: ANN401 whatever a message holds
    """Return a message of any definition as dictionaries and lists, as `to_plain` does for those that are known."""
    if isinstance(value, list):
        return [plain(one) for one in value]
    if not hasattr(value, "__msgtype__"):
        return to_plain(value)
    return {
        key: plain(getattr(value, key)) for key in value.__dataclass_fields__ if key not in ("__msgtype__", NO_FIELD)
    }


def _typedefs(name: str, defined: Mapping[str, tuple[Any, Iterable[tuple[str, Description]]]]) -> Iterator[dict]:
    """Yield what a message and all that it holds consist of, as rosapi tells it."""
    todo, seen = [name], {name}
    while todo:
        type = todo.pop(0)
        told = [(key, one) for key, one in defined[type][1] if key != NO_FIELD]
        inner = [_inner(one) for _, one in told]
        lengths = [-1 if int(k) in (BASE, MESSAGE) else d[1] if int(k) == ARRAY else 0 for _, (k, d) in told]
        yield {"type": type, "fieldnames": [key for key, _ in told], "fieldtypes": inner, "fieldarraylen": lengths}
        todo += [one for one in dict.fromkeys(inner) if "/" in one and one not in seen]
        seen.update(inner)


def _inner(one: Description) -> str:
    kind, detail = int(one[0]), one[1]
    return detail[0] if kind == BASE else detail if kind == MESSAGE else _inner(detail[0])


if __name__ == "__main__":
    sys.exit(main())
