"""Demonstrations: a file becomes a dataset that readers of Parquet and films take; a kernel's is played back."""

from __future__ import annotations

import json
from pathlib import Path

import av
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError, MotionEndedError
from virtualrobot.recording.mcap_file import McapFile
from virtualrobot.v1 import signal_pb2
from virtualrobot_apps.episodes.command import episode
from virtualrobot_apps.episodes.dataset import write_dataset
from virtualrobot_apps.episodes.episode import next_file, read_episode

from tests.api.asking import IIWA
from tests.kernels import KernelProcess

FPS = 10
NAMES = ("a", "b")
GREY = 90


def written(file: Path, seconds: float, *, robot: str = "arm", camera: bool = True) -> Path:
    """Write a demonstration of two joints, a at the time and b at twice of it, a gripper that closes, and a camera."""
    with file.open("wb") as stream:
        made = McapFile(stream, {})
        for tick in range(round(seconds * 250) + 1):
            time, nano = tick / 250, tick * 4_000_000
            joints, pose = JointStates(), PoseInFrame(frame_id="world")
            for place, name in enumerate(NAMES, 1):
                joints.joints.add(name=name, position=place * time)
            pose.pose.position.x, pose.pose.orientation.w = time, 1.0
            made.write(f"/robots/{robot}/joint_states", joints, nano)
            made.write(f"/robots/{robot}/tcp", pose, nano)
            if tick % 125 == 0:
                closed = signal_pb2.Signal(name="gripper")
                closed.value.boolean = time >= 0.5
                made.write("/signals/gripper", closed, nano)
            if camera and tick % 25 == 0:
                image = RawImage(width=32, height=16, encoding="rgb8", step=96, data=bytes([GREY]) * 16 * 96)
                made.write("/sensors/eye/color", image, nano)
        made.close()
    return file


def test_a_dataset_has_what_its_readers_ask_for(tmp_path: Path) -> None:
    folder = tmp_path / "demos"
    folder.mkdir()
    for seconds in (1.0, 0.5):
        written(next_file(folder), seconds)
    target = tmp_path / "data"
    told = CliRunner().invoke(
        episode, ["dataset", str(folder), str(target), "--fps", str(FPS), "--task", "put it away"]
    )
    assert told.exit_code == 0, told.output
    assert told.output == f"{target}: 2 episodes, 17 frames\n"

    about = json.loads((target / "meta/info.json").read_text())
    assert (about["codebase_version"], about["fps"], about["robot_type"]) == ("v3.0", FPS, "arm")
    assert (about["total_episodes"], about["total_frames"], about["splits"]) == (2, 17, {"train": "0:2"})
    assert about["features"]["action"] == {"dtype": "float32", "shape": [3], "names": ["a", "b", "gripper"]}
    assert about["features"]["observation.images.eye"]["shape"] == [16, 32, 3]
    tasks = pd.read_parquet(target / "meta/tasks.parquet")
    assert tasks.loc["put it away"].task_index == 0

    # Episodes are found by what is written of them, as a reader finds them.
    episodes = pd.read_parquet(target / "meta/episodes")
    assert episodes.length.tolist() == [11, 6]
    for row in episodes.to_dict("records"):
        place = {"chunk_index": row["data/chunk_index"], "file_index": row["data/file_index"]}
        table = pd.read_parquet(target / about["data_path"].format(**place))
        assert len(table) == row["length"] == row["dataset_to_index"] - row["dataset_from_index"]
        assert table["index"].tolist() == list(range(row["dataset_from_index"], row["dataset_to_index"]))
        times = np.arange(len(table)) / FPS
        np.testing.assert_allclose(table.timestamp, times, atol=1e-6)
        state, action = np.array(list(table["observation.state"])), np.array(list(table["action"]))
        np.testing.assert_allclose(state, np.column_stack([times, 2 * times, times >= 0.5]), atol=1e-6)
        np.testing.assert_array_equal(action, np.vstack([state[1:], state[-1:]]))
        np.testing.assert_allclose(np.array(list(table["observation.pose"]))[:, 0], times, atol=1e-6)
        key = "observation.images.eye"
        place = {"chunk_index": row[f"videos/{key}/chunk_index"], "file_index": row[f"videos/{key}/file_index"]}
        with av.open(str(target / about["video_path"].format(video_key=key, **place)), "r") as film:
            frames = list(film.decode(video=0))
        np.testing.assert_allclose([float(frame.time or 0.0) for frame in frames], times, atol=1e-4)
        assert abs(int(frames[0].to_ndarray(format="rgb24").mean()) - GREY) < 4  # of 255, by its compression
        assert row[f"videos/{key}/to_timestamp"] == pytest.approx(len(table) / FPS)
    stats = json.loads((target / "meta/stats.json").read_text())
    np.testing.assert_allclose(stats["observation.state"]["max"], [1.0, 2.0, 1.0])
    np.testing.assert_allclose(np.ravel(stats["observation.images.eye"]["mean"]), GREY / 255)
    assert np.shape(stats["observation.images.eye"]["std"]) == (3, 1, 1)


def test_bad_demonstrations_are_refused(tmp_path: Path) -> None:
    one = read_episode(written(tmp_path / "one.mcap", 0.5))
    with pytest.raises(MissingFileError, match=r"none\.mcap cannot be read"):
        read_episode(tmp_path / "none.mcap")
    (tmp_path / "half.mcap").write_bytes((tmp_path / "one.mcap").read_bytes()[:2000])
    with pytest.raises(MalformedFileError, match="is no whole MCAP file"):
        read_episode(tmp_path / "half.mcap")
    with pytest.raises(InvalidArgumentError, match="has the robots arm; 'leg' is not among them"):
        read_episode(tmp_path / "one.mcap", "leg")
    blind = read_episode(written(tmp_path / "blind.mcap", 0.5, camera=False))
    with pytest.raises(InvalidArgumentError, match=r"are alike: .*cameras: none.* is not .*cameras: eye"):
        write_dataset([one, blind], tmp_path / "mixed", fps=FPS, task="")
    with pytest.raises(InvalidArgumentError, match="shorter than two frames"):
        write_dataset([one], tmp_path / "short", fps=1, task="")
    with pytest.raises(InvalidArgumentError, match="has something in it"):
        write_dataset([one], tmp_path, fps=FPS, task="")
    told = CliRunner().invoke(episode, ["dataset", str(tmp_path / "nowhere"), str(tmp_path / "x"), "--task", "none"])
    assert isinstance(told.exception, InvalidArgumentError) and "episode-000000.mcap" in str(told.exception)
    assert not (tmp_path / "mixed").exists() and not (tmp_path / "short").exists()


def test_what_a_robot_did_it_does_again(client: Client, kernel: KernelProcess, tmp_path: Path) -> None:
    arm = client.load_robot(IIWA, name="arm")
    slow = arm.move_joints([2.0, 0.5, 0.0, -0.5, 0.0, 0.5, 0.0], speed_factor=0.02, wait=False)
    address = ["--address", kernel.address]
    told = CliRunner().invoke(episode, ["record", str(tmp_path), "--seconds", "1.0", *address])
    assert told.exit_code == 0, told.output
    slow.cancel()
    with pytest.raises(MotionEndedError):
        slow.wait(60)
    file = tmp_path / "episode-000000.mcap"
    assert f"{file}: 1.0 s" in told.output
    recorded = read_episode(file)
    frames = np.asarray(recorded.positions.at(recorded.times(30)))
    assert np.ptp(frames[:, 0]) > 0.01
    arm.set_positions([0.0] * 7)
    told = CliRunner().invoke(episode, ["play", str(file), *address])
    assert told.exit_code == 0, told.output
    np.testing.assert_allclose(arm.positions, frames[-1], atol=1e-6)
