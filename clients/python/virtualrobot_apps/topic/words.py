"""Streams and samples in words, and values that somebody types."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import click
import numpy as np
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.statistics import Bandwidth, Delay, Rate
from virtualrobot.streams.streams import rate_words
from virtualrobot.streams.table import Stream
from virtualrobot.tables import aligned


def list_lines(streams: Sequence[Stream]) -> list[str]:
    """Return streams as lines of a table: name, type, rate, unit, frame, direction."""
    rows = [[one.name, one.type, rate_words(one), one.unit, one.frame, one.direction] for one in streams]
    return aligned([["stream", "type", "rate", "unit", "frame", "direction"], *rows], left=6)


def info_lines(stream: Stream, sample: Sample | None) -> list[str]:
    """Return what is known of a stream, with the fields of a sample."""
    lines = [
        stream.name,
        f"  type       {stream.type}",
        f"  rate       {rate_words(stream)}",
        f"  unit       {stream.unit or '-'}",
        f"  frame      {stream.frame or '-'}",
        f"  direction  {stream.direction}",
    ]
    if sample is not None:
        lines += ["  fields", *(f"    {name} = {shown(value)}" for name, value in sample.values.items())]
    return lines


def shown(value: Any) -> str:  # noqa: ANN401 a value of a sample
    """Return a value in a few letters; of an array its shape and range."""
    if isinstance(value, np.ndarray):
        finite = value[np.isfinite(value)] if value.dtype.kind == "f" else value
        span = f" from {finite.min():g} to {finite.max():g}" if finite.size else ", none finite"
        return f"{' x '.join(map(str, value.shape))} {value.dtype}{span}"
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def echo_line(sample: Sample, fields: Sequence[str]) -> str:
    """Return a sample in one line: those fields, or all."""
    values = {name: value for name, value in sample.values.items() if not fields or name in fields}
    said = "  ".join(f"{name}={shown(value)}" for name, value in values.items())
    lost = f"  ({sample.lost} lost)" if sample.lost else ""
    return f"{sample.time:10.3f} s  {sample.stream}  {said}{lost}"


def echo_json(sample: Sample) -> str:
    """Return a sample as a line of JSON; numbers that are not finite are null."""
    values = {name: _plain(value) for name, value in sample.values.items()}
    return json.dumps(
        {"stream": sample.stream, "time": sample.time, "tick": sample.tick, "lost": sample.lost, "values": values}
    )


def _plain(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, np.ndarray):
        return [_plain(one) for one in value.tolist()]
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def rate_line(name: str, one: Rate) -> str:
    """Return a rate in one line."""
    if math.isnan(one.mean):
        return f"{name}: {one.count} sample{'s' * (one.count != 1)}, too few for a rate"
    periods = f"period {1e3 * one.shortest:.3f} to {1e3 * one.longest:.3f} ms, deviation {1e3 * one.deviation:.3f} ms"
    return f"{name}: {one.mean:.3f} Hz, {periods}, {one.count} samples, {one.lost} lost"


def bandwidth_line(name: str, one: Bandwidth) -> str:
    """Return a bandwidth in one line."""
    if math.isnan(one.mean):
        return f"{name}: {one.count} sample{'s' * (one.count != 1)}, too few for a bandwidth"
    return f"{name}: {one.mean / 1e3:.3f} kB/s, {one.total / max(one.count, 1):.0f} bytes each, {one.count} samples"


def delay_line(name: str, one: Delay) -> str:
    """Return a delay in one line."""
    if not one.count:
        return f"{name}: nothing came"
    span = f"{1e3 * one.shortest:.2f} to {1e3 * one.longest:.2f} ms"
    return f"{name}: {1e3 * one.mean:.2f} ms in the mean, {span}, {one.count} samples"


def numbers_of_words(words: Sequence[str]) -> list[float] | dict[str, float]:
    """Return numbers in order, or by name where words are NAME=NUMBER; raise UsageError for others."""
    try:
        if all("=" in word for word in words):
            return {name: float(number) for name, _, number in (word.partition("=") for word in words)}
        return [float(number) for word in words for number in word.split(",") if number]
    except ValueError as error:
        raise click.UsageError(f"{' '.join(words)!r} is neither numbers nor NAME=NUMBER") from error
