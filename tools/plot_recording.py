"""Writes the picture of docs/recording.md: joints and tool of an arm, read from a recording (MCAP).

Usage: python tools/plot_recording.py docs/pictures
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
import virtualrobot
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.chart import Panel, chart

IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
READY, THERE = (0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2), (1.5, 0.2, 0.4, -0.6, 0.8, 0.3, -0.5)
EVERY = 3
"""One of so many ticks is drawn: more would only make the picture larger."""


def record(path: Path) -> None:
    """Record an arm that moves to and fro, each tick of it."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.set_stepped()
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions(READY)
        with client.start_recording(path, topics=["/robots/*"]) as recording:
            for goal in (THERE, READY):
                motion = arm.move_joints(goal, wait=False, on_disconnect="continue")
                while not motion.state.phase.ended:
                    recording.step(5)


def draw(path: Path) -> str:
    """Return the picture of a recording as SVG."""
    times, positions, places = [], [], []
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, told in reader.iter_decoded_messages():
            if channel.topic.endswith("/tcp"):
                places.append([told.pose.position.x, told.pose.position.y, told.pose.position.z])
            else:
                times.append(message.log_time / 1e9)
                positions.append([joint.position for joint in told.joints])
    names = [f"joint {number}" for number in range(1, 8)]
    panels = [
        Panel("position in rad", names, np.array(positions)[::EVERY]),
        Panel("tool in m", ["x", "y", "z"], np.array(places)[::EVERY]),
    ]
    return chart((np.array(times) - times[0])[::EVERY], panels)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
def main(folder: Path) -> None:
    """Write recording.svg to FOLDER."""
    with tempfile.TemporaryDirectory() as temporary:
        path = Path(temporary) / "run.mcap"
        record(path)
        (folder / "recording.svg").write_text(draw(path), "utf-8")


if __name__ == "__main__":
    main()
