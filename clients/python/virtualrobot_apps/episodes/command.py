"""`virtualrobot episode`: demonstrations recorded, made a dataset for learning, played back."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import Target, target_options
from virtualrobot.errors import InvalidArgumentError

FPS = 30
FOLDER = click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
ROBOT = click.option("--robot", default="", help="Whose demonstration it is; needed where there are several.")


@click.group(short_help="Record demonstrations, make them a dataset for learning, play them back.")
def episode() -> None:
    """Record demonstrations of a robot, make them a dataset that LeRobot reads, and play them back."""


@episode.command()
@FOLDER
@ROBOT
@click.option("--seconds", type=click.FloatRange(0.0, min_open=True), help="Of simulation time [until Ctrl-C].")
@target_options
def record(target: Target, folder: Path, robot: str, seconds: float | None) -> None:
    """Record what a robot does, signals and cameras, to the next episode-000000.mcap of FOLDER."""
    from virtualrobot_apps.episodes.episode import next_file, topics_of

    folder.mkdir(parents=True, exist_ok=True)
    with target.connect() as client:
        names = list(client.robots)
        if robot not in names and (robot or len(names) != 1):
            said = f"there is no robot {robot!r}" if robot else "say by --robot whose demonstration it is"
            raise InvalidArgumentError(f"{said}; known: {', '.join(names) or 'none'}")
        file = next_file(folder)
        recording = client.start_recording(file, duration=seconds, topics=topics_of(robot or names[0]))
        try:
            while not recording.wait(0.25):
                pass
        except KeyboardInterrupt:
            pass  # the file is made whole with what there is
        recorded = recording.finish()
    click.echo(f"{file}: {recorded.end - recorded.start:.1f} s")


@episode.command()
@FOLDER
@click.argument("dataset", type=click.Path(file_okay=False, path_type=Path))
@ROBOT
@click.option("--fps", type=click.IntRange(1, 1000), default=FPS, show_default=True, help="Frames a second.")
@click.option("--task", required=True, help="What is done in all of them, in words that a policy is told.")
def dataset(folder: Path, dataset: Path, robot: str, fps: int, task: str) -> None:
    """Make the episodes of FOLDER a dataset of LeRobot 3.0 in DATASET; no kernel is needed."""
    from virtualrobot_apps.episodes.dataset import write_dataset
    from virtualrobot_apps.episodes.episode import files_in, read_episode

    files = list(files_in(folder))
    if not files:
        raise InvalidArgumentError(
            f"{folder} has no episode-000000.mcap; 'virtualrobot episode record {folder}' makes one"
        )
    episodes = [read_episode(file, robot) for file in files]
    total = write_dataset(episodes, dataset, fps=fps, task=task)
    click.echo(f"{dataset}: {len(episodes)} episodes, {total} frames")


@episode.command()
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path), metavar="EPISODE.mcap")
@ROBOT
@target_options
def play(target: Target, file: Path, robot: str) -> None:
    """Have a robot go to the begin of EPISODE.mcap and do what it has, checked as any motion before."""
    from virtualrobot_apps.episodes.episode import read_episode

    read = read_episode(file, robot)
    times = read.times(FPS)
    positions = read.positions.at(times)
    with target.connect() as client:
        arm = client.robot(read.robot)
        program = [arm.ptp(dict(zip(read.joints, positions[0], strict=True)))]
        if len(times) > 1:
            program.append(arm.trajectory(times - times[0], positions, joints=read.joints))
        for move in program:
            client.move_together([move])
    click.echo(f"{read.robot} did {file}: {times[-1] - times[0]:.1f} s")
