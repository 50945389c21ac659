"""`virtualrobot topic`: list, info, echo, hz, bw, delay, plot, pub, record and play of streams."""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, WholeRange, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot topic list
  virtualrobot topic echo /robots/ugv/base --count 3
  virtualrobot topic hz '/sensors/*' --seconds 5
  virtualrobot topic plot /nodes/arm.link_7/pose:speed --seconds 10 --out speed.svg
  virtualrobot topic plot /nodes/ugv.base/pose --trail --seconds 20 --out way.png
  virtualrobot topic plot 'arm/*/velocity' --file run.csv
  virtualrobot topic pub /robots/ugv/command/twist 0.3 0 0.5 --seconds 2
"""

ABOVE_ZERO = FiniteRange(0.0, min_open=True)
_names = click.argument("names", nargs=-1, required=True, metavar="STREAM...")
_seconds = click.option("--seconds", type=ABOVE_ZERO, help="Of simulation time [until Ctrl-C].")


@click.group(epilog=_EXAMPLES, short_help="List, show, measure, plot, publish, record and play what a world tells.")
@target_options
@click.pass_context
def topic(ctx: click.Context, target: Target) -> None:
    """Streams of a world: all that it tells, and what it hears.

    STREAM is a name, or a pattern such as '/robots/*'. Sensors read while they are listened to.
    """
    ctx.obj = target


@topic.command("list")
@click.argument("patterns", nargs=-1, metavar="[STREAM...]")
@target_options
def list_streams(target: Target, patterns: tuple[str, ...]) -> None:
    """Show the streams that there are, or some: type, rate, unit, frame and direction."""
    from virtualrobot.streams.table import chosen

    from virtualrobot_apps.topic.words import list_lines

    with target.connect() as client:
        click.echo("\n".join(list_lines(chosen(client.streams.table(), patterns))))


@topic.command()
@click.argument("name", metavar="STREAM")
@target_options
def info(target: Target, name: str) -> None:
    """Show what a stream is, and the fields of what it tells now."""
    from virtualrobot_apps.topic.words import info_lines

    with target.connect() as client:
        stream = client.streams[name]
        sample = None
        if stream.direction != "in":
            with client.streams.watch(name) as watch:
                sample = watch.next(1.0)
        click.echo("\n".join(info_lines(stream, sample)))


@topic.command()
@_names
@click.option("--count", type=WholeRange(min=1), help="End after so many samples.")
@click.option("--field", "fields", multiple=True, help="Only this field; may be given again.")
@click.option("--lines", is_flag=True, help="A line of JSON for each sample, with whole arrays.")
@_seconds
@target_options
def echo(
    target: Target,
    names: tuple[str, ...],
    count: int | None,
    fields: tuple[str, ...],
    lines: bool,
    seconds: float | None,
) -> None:
    """Print what streams tell, a line for each sample, every tick and every reading."""
    from virtualrobot_apps.topic.gathering import taken, watched
    from virtualrobot_apps.topic.words import echo_json, echo_line

    with target.connect() as client, watched(client, names) as watch, suppress(KeyboardInterrupt):
        for number, sample in enumerate(taken(watch, names, seconds), 1):
            if fields and number == 1 and not set(fields) & sample.values.keys():
                there = ", ".join(sample.values)
                raise click.UsageError(f"{sample.stream} has no field {fields[0]!r}; there are {there}")
            click.echo(echo_json(sample) if lines else echo_line(sample, fields))
            if number == count:
                break


@topic.command()
@_names
@_seconds
@target_options
def hz(target: Target, names: tuple[str, ...], seconds: float | None) -> None:
    """Measure how often streams tell, in simulation time, and how many samples were lost."""
    from virtualrobot.streams.statistics import rate

    from virtualrobot_apps.topic.gathering import gathered
    from virtualrobot_apps.topic.words import rate_line

    for name, samples in gathered(target, names, seconds).items():
        click.echo(rate_line(name, rate([sample for sample, _ in samples])))


@topic.command()
@_names
@_seconds
@target_options
def bw(target: Target, names: tuple[str, ...], seconds: float | None) -> None:
    """Measure how many bytes streams tell in a second of simulation time."""
    from virtualrobot.streams.statistics import bandwidth

    from virtualrobot_apps.topic.gathering import gathered
    from virtualrobot_apps.topic.words import bandwidth_line

    for name, samples in gathered(target, names, seconds).items():
        click.echo(bandwidth_line(name, bandwidth([sample for sample, _ in samples])))


@topic.command()
@_names
@_seconds
@target_options
def delay(target: Target, names: tuple[str, ...], seconds: float | None) -> None:
    """Measure how long after its instant each sample comes, by the clocks of both machines."""
    from virtualrobot.streams.statistics import delay as measured

    from virtualrobot_apps.topic.gathering import gathered
    from virtualrobot_apps.topic.words import delay_line

    for name, samples in gathered(target, names, seconds).items():
        click.echo(delay_line(name, measured(samples)))


@topic.command()
@click.argument("curves", nargs=-1, required=True, metavar="CURVE...")
@click.option("--file", "recorded", type=click.Path(path_type=Path), help="Of a recording instead of what happens now.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="A picture: .svg or .png [this terminal].")
@click.option("--trail", is_flag=True, help="The way in x and y from above, of poses.")
@click.option("--seconds", type=ABOVE_ZERO, default=10.0, help="Of simulation time [10, or until Ctrl-C].")
@target_options
def plot(
    target: Target, curves: tuple[str, ...], recorded: Path | None, out: Path | None, trail: bool, seconds: float
) -> None:
    r"""Plot numbers over time, live or of a recording, to a picture or with letters in this terminal.

    \b
    CURVE is
      STREAM             all numbers of a stream, such as /robots/arm/tcp
      STREAM:FIELD       one of them; poses have 'speed' (m/s), too; * stands for any letters
      'CURVE - CURVE'    their difference, such as an error
      a column           of a recording, such as arm/joint_1/velocity
    """
    from virtualrobot_apps.topic import curves as of
    from virtualrobot_apps.topic import drawing
    from virtualrobot_apps.topic import recorded as files
    from virtualrobot_apps.topic.gathering import drawn_live

    if out is not None:
        drawing.check(out)
    if trail and out is None:
        raise click.UsageError("a trail is drawn to a picture: say --out")
    if recorded is not None:
        found = files.curves(recorded)
    else:
        names = of.streams_of(curves)
        found = of.of_samples(drawn_live(target, names, curves, seconds, shows=out is None and sys.stdout.isatty()))
    if trail and out is not None:
        drawing.write(out, ways=of.trails(found, curves))
    else:
        wanted = [one for one in of.chosen(found, curves) if len(one.times) > 1]
        if not wanted:
            raise click.ClickException(f"{', '.join(curves)}: fewer than two samples came; nothing to draw")
        if out is None:
            click.echo(drawing.letters(wanted))
            return
        drawing.write(out, wanted)
    click.echo(f"picture in {out}")


@topic.command()
@click.argument("sensor")
@click.option("--cell", type=FiniteRange(0.001, 1.0), default=0.02, show_default=True, help="Edge of a cell in meters.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="A picture from above: .svg.")
@_seconds
@target_options
def heat(target: Target, sensor: str, cell: float, out: Path | None, seconds: float | None) -> None:
    """Gather where a contact SENSOR is touched and how much, and draw it in the world: a heat map.

    Values are impulses (N s) under physics, and elsewhere times (s). The drawing stays, as 'heat of SENSOR'.
    """
    from virtualrobot_apps.topic.heat import gathered

    if out is not None and (out.suffix != ".svg" or not out.absolute().parent.is_dir()):
        raise click.UsageError("--out takes a name that ends in .svg, in a folder that is there")
    with target.connect() as client:
        found = gathered(client, sensor, cell, seconds)
    click.echo(found.told())
    if out is not None and len(found.values):
        out.write_text(found.picture(), "utf-8")
        click.echo(f"picture in {out}")


@topic.command()
@click.argument("name", metavar="STREAM")
@click.argument("value", nargs=-1, required=True)
@click.option("--rate", type=ABOVE_ZERO, default=20.0, help="Commands of robots: how often a second [20].")
@click.option("--seconds", type=ABOVE_ZERO, help="Commands of robots: how long, of simulation time.")
@target_options
def pub(target: Target, name: str, value: tuple[str, ...], rate: float, seconds: float | None) -> None:
    """Publish VALUE to a stream that the world hears: a signal once, a command of a robot for --seconds.

    VALUE is for a signal on or off, a number, a text, or for a group a 0 or 1 for each of its booleans; else numbers in
    order, or NAME=NUMBER. A number that is negative stands behind --.
    """
    from virtualrobot.cli.signals import signal_value

    from virtualrobot_apps.topic.words import numbers_of_words

    with target.connect() as client:
        stream = client.streams[name]
        if stream.watch == "signals":
            if seconds:
                raise click.UsageError("a signal keeps its value; --seconds is for commands of robots")
            client.signals[stream.about] = signal_value(client.signals[stream.about], " ".join(value))
            return
        if stream.direction != "in":
            raise click.UsageError(f"{name} is told by the world; nobody else publishes it")
        if seconds is None:
            raise click.UsageError("say for how many --seconds")
        if client.clock.mode == "stepped":
            raise click.UsageError("time stands still; 'virtualrobot step --realtime' lets it go on by itself again")
        told = numbers_of_words(value)
        with client.streams.publisher(name, timeout=max(0.5, 3.0 / rate)) as publisher:
            begin = client.clock.simulation_time  # a busy machine takes a while until here
            while client.clock.simulation_time - begin < seconds:
                publisher.send(told)
                time.sleep(1.0 / rate)


@topic.command()
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@click.argument("patterns", nargs=-1, metavar="[STREAM...]")
@_seconds
@click.option("--rate", type=ABOVE_ZERO, help="The most states a second [each tick].")
@click.option("--overwrite", is_flag=True, help="Replace a file that is there.")
@target_options
def record(
    target: Target,
    output: Path,
    patterns: tuple[str, ...],
    seconds: float | None,
    rate: float | None,
    overwrite: bool,
) -> None:
    """Record streams to OUTPUT (.mcap, .csv, .parquet), as 'virtualrobot record' does; Ctrl-C leaves a whole file."""
    with target.connect() as client:
        recording = client.start_recording(output, duration=seconds, topics=patterns, rate=rate, overwrite=overwrite)
        with suppress(KeyboardInterrupt):
            while not recording.wait(0.25):
                continue
        recorded = recording.finish()
    counted = ", ".join(f"{count} of {name}" for name, count in sorted(recorded.counts.items()))
    click.echo(f"{output}: {recorded.end - recorded.start:.3f} s: {counted or 'nothing'}")
    if recorded.missed_ticks or recorded.missed_readings:
        click.echo(f"{recorded.missed_ticks} ticks and {recorded.missed_readings} readings were lost", err=True)


@topic.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--only", "patterns", multiple=True, metavar="PATTERN", help="Columns, such as 'arm/*' or 'signals/*'.")
@click.option("--speed", type=ABOVE_ZERO, default=1.0, help="Recorded seconds a second of simulation time [1].")
@target_options
def play(target: Target, file: Path, patterns: tuple[str, ...], speed: float) -> None:
    """Play a recording in the world: joints of robots stand, and signals are, as they were, one moment after the other.

    Robots are put there, without a motion: what they are in the world with the same names and joints.
    """
    from virtualrobot_apps.topic.playing import play as played

    with target.connect() as client:
        end = played(client, file, patterns, speed)
    click.echo(f"{file}: {end.rows} rows in {end.seconds:.3f} s, of {', '.join(end.names)}")
