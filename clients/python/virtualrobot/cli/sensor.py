"""`virtualrobot sensor`: sensors at work, and what they say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.camera_files import KINDS, write_pictures
from virtualrobot.cli.names import SENSOR
from virtualrobot.cli.options import Target, WholeRange, target_options
from virtualrobot.cli.sensor_view import hide, show
from virtualrobot.cli.sensor_words import contact_lines, said
from virtualrobot.cli.settings import settings_from, settings_option

if TYPE_CHECKING:
    from virtualrobot.sensors.readings import Reading, SensorPreset, SensorStatus

_EXAMPLES = """
\b
Examples:
  virtualrobot sensor
  virtualrobot sensor start lidar
  virtualrobot sensor read lidar --out scan.ply --frame world
  virtualrobot sensor read camera --kind color --kind depth --out seen.npz
  virtualrobot sensor watch lidar
  virtualrobot sensor show lidar
  virtualrobot sensor set lidar --model laser --set deviation_meters=0.02
"""

FRAMES = click.Choice(["sensor", "robot", "world"])
ENDINGS = {"range_sensor": (".npz", ".ply", ".csv"), "camera_sensor": (".npz",)}
"""Endings of the files that readings are written to, by kind of sensor; those of other kinds are a few numbers."""


@click.group(invoke_without_command=True, epilog=_EXAMPLES)
@target_options
@click.pass_context
def sensor(ctx: click.Context, target: Target) -> None:
    """Show all sensors and how they are; or start, stop, read and watch them."""
    ctx.obj = target
    if ctx.invoked_subcommand is None:
        with target.connect() as client:
            click.echo("\n".join(status_lines(client.sensors.statuses())))


sensor.add_command(show)
sensor.add_command(hide)


@sensor.command()
@click.argument("names", nargs=-1, type=SENSOR)
@target_options
def start(target: Target, names: tuple[str, ...]) -> None:
    """Let the sensors NAMES (or all) read at their rates; those with a fault are tried anew."""
    with target.connect() as client:
        client.sensors.start(*names)


@sensor.command()
@click.argument("names", nargs=-1, type=SENSOR)
@target_options
def stop(target: Target, names: tuple[str, ...]) -> None:
    """Let the sensors NAMES (or all) read no more."""
    with target.connect() as client:
        client.sensors.stop(*names)


@sensor.command()
@click.argument("name", type=SENSOR)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write it too: .npz, .ply, .csv.")
@click.option("--frame", type=FRAMES, help="Of the points of a range sensor [sensor].")
@click.option("--kind", "kinds", type=click.Choice(KINDS), multiple=True, help="Of a camera; several may be given.")
@target_options
def read(target: Target, name: str, out: Path | None, frame: str | None, kinds: tuple[str, ...]) -> None:
    """Make one reading of the sensor NAME, whether it runs or not."""
    with target.connect() as client:
        handle = client.sensors[name]
        kind = handle.status.kind
        check_options(name, kind, out, frame, kinds)
        reading = handle.read(points=True, frame=frame or "sensor", intensities=True, elements=True, images=kinds)
    click.echo("\n".join(reading_lines(reading)))
    if out is not None:
        write = write_pictures if kind == "camera_sensor" else write_points
        write(out, reading)


@sensor.command()
@click.argument("names", nargs=-1, type=SENSOR)
@click.option("--count", type=WholeRange(min=1), help="End after so many readings.")
@target_options
def watch(target: Target, names: tuple[str, ...], count: int | None) -> None:
    """Print a line for each reading of the sensors NAMES (or all), as they come; Ctrl-C ends it."""
    with target.connect() as client:
        for number, reading in enumerate(client.sensors.watch(*names, elements=True), 1):
            click.echo(reading_line(reading))
            if number == count:
                break


@sensor.command("set")
@click.argument("name", type=SENSOR)
@click.option("--ray-caster", metavar="COMPONENT", help="What finds the hits of its rays.")
@click.option("--model", metavar="COMPONENT", help="What makes readings of them.")
@settings_option
@target_options
def set_components(
    target: Target, name: str, ray_caster: str | None, model: str | None, values: tuple[str, ...]
) -> None:
    """Give the range sensor NAME another ray caster, or another sensor model; it is tried first.

    --set gives the settings of that component.
    """
    if (ray_caster is None) == (model is None):
        raise click.UsageError("say --ray-caster or --model")
    kind, component = ("ray_caster", ray_caster) if ray_caster is not None else ("sensor_model", model or "")
    with target.connect() as client:
        schemas = {known.name: known.settings_schema for known in client.plugins.components(kind)}
        settings = settings_from(values, schemas.get(component, {}))
        handle = client.sensors[name]
        trial = (handle.set_ray_caster if kind == "ray_caster" else handle.set_model)(component, settings)
    click.echo(f"{trial.rays:,} rays in {1e3 * trial.cast_time:.3f} ms, model {1e3 * trial.model_time:.3f} ms")


@sensor.command()
@target_options
def presets(target: Target) -> None:
    """Show the devices that a range sensor may be set as."""
    with target.connect() as client:
        click.echo("\n".join(preset_lines(list(client.sensors.presets().values()))))


def check_options(name: str, kind: str, out: Path | None, frame: str | None, images: Sequence[str]) -> None:
    """Raise click.UsageError for options that say nothing about a sensor of this kind."""
    if frame is not None and kind != "range_sensor":
        raise click.UsageError(f"--frame is for range sensors, and {name!r} is a {kind}")
    if images and kind != "camera_sensor":
        raise click.UsageError(f"--kind is for cameras, and {name!r} is a {kind}")
    if out is None:
        return
    if kind not in ENDINGS:
        raise click.UsageError(f"--out is for range sensors and cameras, and {name!r} is a {kind}")
    if out.suffix not in ENDINGS[kind]:
        more = f"; `virtualrobot capture --camera {name}` writes .png" if kind == "camera_sensor" else ""
        endings = " or ".join(ENDINGS[kind])
        raise click.UsageError(f"--out ends with {endings} for a {kind}, not {out.suffix or out.name!r}{more}")


def status_lines(sensors: Sequence[SensorStatus]) -> list[str]:
    """Return sensors as lines of a table."""
    from virtualrobot.tables import aligned

    if not sensors:
        return ["there is no sensor"]
    rows = []
    for one in sensors:
        work = f"{one.readings} reading{'s' * (one.readings > 1)}" if one.readings else ""
        work += f" of {1e3 * one.mean_reading_time:.2f} ms" if one.readings else ""
        work += f", {one.missed} missed" if one.missed else ""
        rows.append([one.name, one.kind, one.state, f"{one.rate:g} Hz", one.fault or work])
    return aligned(rows, left=5)


def preset_lines(presets: Sequence[SensorPreset]) -> list[str]:
    """Return devices as lines of a table."""
    from virtualrobot.tables import aligned

    return aligned([[one.name, one.description] for one in presets], left=2)


def reading_line(reading: Reading) -> str:
    """Return a reading in one line."""
    words = f"{reading.stamp.simulation_time:10.3f} s  {reading.sensor}  {reading.number}"
    return f"{words}  {reading.fault or _said(reading)}"


def reading_lines(reading: Reading) -> Iterator[str]:
    """Yield a reading in several lines."""
    from virtualrobot.sensors.range_sensors import RangeReading

    yield reading_line(reading)
    if isinstance(reading.value, RangeReading):
        names = [(int(reading.value.mask(name).sum()), name) for name in reading.value.element_names]
        yield from (
            f"  {count:8} beam{'s' * (count > 1)} on {name}" for count, name in sorted(names, reverse=True) if count
        )
    elif isinstance(reading.value, tuple):
        yield from contact_lines(reading.value)


def write_points(path: Path, reading: Reading) -> None:
    """Write the points of a range sensor: as arrays (.npz), as a point cloud (.ply) or as a table (.csv)."""
    import numpy as np

    scan = reading.range
    assert scan.points is not None and scan.intensities is not None and scan.elements is not None
    if path.suffix == ".npz":
        np.savez_compressed(
            path,
            distances=scan.distances,
            valid=scan.valid,
            intensities=scan.intensities,
            elements=scan.elements,
            element_names=np.array(scan.element_names),
            points=scan.points,
            frame=scan.frame,
            world_t_sensor=reading.world_t_sensor,
            simulation_time_seconds=reading.stamp.simulation_time,
        )
        return
    rows = np.column_stack((scan.points[scan.valid], scan.intensities[scan.valid]))
    if path.suffix == ".csv":
        np.savetxt(path, rows, "%.6g", ",", header="x,y,z,intensity", comments="")
        return
    header = ["ply", "format ascii 1.0", f"comment meters in the {scan.frame}'s frame", f"element vertex {len(rows)}"]
    header += [f"property float {name}" for name in ("x", "y", "z", "intensity")]
    np.savetxt(path, rows, "%.6g", " ", header="\n".join([*header, "end_header"]), comments="")


def _said(reading: Reading) -> str:
    import numpy as np

    from virtualrobot.sensors.range_sensors import RangeReading

    value = reading.value
    if value is None:
        return reading.state
    if not isinstance(value, RangeReading):
        return said(value)
    found = value.distances[value.valid]
    shape = " x ".join(map(str, value.distances.shape))
    beams = "1 beam" if value.distances.size == 1 else f"{shape} beams"
    if not found.size:
        return f"{beams}, no echo"
    if found.size == 1:
        return f"{beams}, 1 echo from {found[0]:.3f} m"
    return f"{beams}, {found.size} echoes from {np.min(found):.3f} m to {np.max(found):.3f} m"
