"""Demonstrations as a dataset of LeRobot, version 3.0: Parquet files of frames, films of cameras, what describes them.

Source: Hugging Face, LeRobotDataset v3.0 (https://huggingface.co/docs/lerobot/lerobot-dataset-v3), and the paths and
columns that its reader asks for. Each episode has files of its own, which the format allows.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.view.film import FilmFile

from virtualrobot_apps.episodes.episode import Episode, pixels_of

VERSION = "v3.0"
CHUNK = 1000
"""Files of a folder at most, as LeRobot has it."""
PATTERN = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA, FILMS = f"data/{PATTERN}.parquet", f"videos/{{video_key}}/{PATTERN}.mp4"
EPISODES, TASKS, INFO, STATS = (
    f"meta/episodes/{PATTERN}.parquet",
    "meta/tasks.parquet",
    "meta/info.json",
    "meta/stats.json",
)

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
STATE, ACTION, TOOL, IMAGE = "observation.state", "action", "observation.pose", "observation.images."
_COUNTED = ("frame_index", "episode_index", "index", "task_index")


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames of an episode at equal steps of time.

    Attributes:
        vectors: (n, k) of each feature, float32.
        pictures: of each camera, one for each frame, as recorded.
    """

    vectors: dict[str, NDArray[np.float32]]
    pictures: dict[str, list[tuple[str, bytes]]]

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.vectors[STATE])


def frames_of(episode: Episode, fps: float) -> Frames:
    """Return the frames of an episode: each has the newest of all that was told.

    An action is what was commanded at that time; of a robot that is where it was commanded, its state one frame later.
    Signals go along with joints in both, since a gripper is one.
    """
    times = episode.times(fps)
    if len(times) < 2:
        raise InvalidArgumentError(f"a demonstration of {episode.robot} is shorter than two frames at {fps:g} a second")
    signals = [episode.signals[name].at(times) for name in sorted(episode.signals)]
    state = np.column_stack([np.asarray(episode.positions.at(times), float), *signals])
    action = np.vstack([state[1:], state[-1:]])
    if episode.commanded.times:
        action[:, : len(episode.joints)] = episode.commanded.at(times)
    vectors = {STATE: state, ACTION: action, TOOL: np.asarray(episode.poses.at(times), float)}
    pictures = {name: track.at(times) for name, track in sorted(episode.pictures.items())}
    return Frames({name: rows.astype(np.float32) for name, rows in vectors.items()}, pictures)


def write_dataset(episodes: Sequence[Episode], folder: Path, *, fps: int, task: str) -> int:
    """Write a dataset to a folder that isn't there yet, or is empty, and return how many frames it has.

    Raises:
        InvalidArgumentError: for episodes that have not the same robot, joints, signals and cameras, for a folder that
            has something in it, and for an episode without two frames.
        WrongStateError: without the libraries that write it.
    """
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise WrongStateError("datasets are Parquet files: pip install 'virtualrobot[parquet]'") from None
    first, *others = episodes
    for other in others:
        if _kind(other) != _kind(first):
            raise InvalidArgumentError(f"episodes of one dataset are alike: {_kind(other)} is not {_kind(first)}")
    if folder.exists() and any(folder.iterdir()):
        raise InvalidArgumentError(f"{folder} has something in it; a dataset is written to a folder of its own")
    written, rows, total = [frames_of(one, fps) for one in episodes], list[dict[str, Any]](), 0
    columns: dict[str, list[NDArray]] = {}
    for number, frames in enumerate(written):
        place = {"chunk_index": number // CHUNK, "file_index": number % CHUNK}
        table = _table(frames, number, total, fps)
        _write_frames(folder / DATA.format(**place), table)
        for name, values in table.items():
            columns.setdefault(name, []).append(values)
        row = {"episode_index": number, "tasks": [task], "length": frames.count}
        row |= {f"data/{name}": value for name, value in place.items()}
        row |= {"dataset_from_index": total, "dataset_to_index": total + frames.count}
        for camera, pictures in frames.pictures.items():
            key = IMAGE + camera
            statistics = _film(folder / FILMS.format(video_key=key, **place), pictures, fps)
            columns.setdefault(key, []).append(statistics)
            row |= {f"videos/{key}/{name}": value for name, value in place.items()}
            row |= {f"videos/{key}/from_timestamp": 0.0, f"videos/{key}/to_timestamp": frames.count / fps}
        for name, values in columns.items():
            row |= {f"stats/{name}/{key}": value for key, value in _statistics(values[-1]).items()}
        rows.append(row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
        total += frames.count
    _write_meta(folder, first, written, rows, total, fps, task)
    stats = {name: _statistics(np.concatenate(values)) for name, values in columns.items()}
    (folder / STATS).write_text(json.dumps(stats, indent=4))
    return total


def _kind(episode: Episode) -> str:
    signals, cameras = ", ".join(sorted(episode.signals)), ", ".join(sorted(episode.pictures))
    return f"{episode.robot} ({', '.join(episode.joints)}; signals: {signals or 'none'}; cameras: {cameras or 'none'})"


def _table(frames: Frames, number: int, begin: int, fps: int) -> dict[str, NDArray]:
    places = np.arange(frames.count)
    return {
        **frames.vectors,
        "timestamp": (places / fps).astype(np.float32),
        "frame_index": places,
        "episode_index": np.full(frames.count, number),
        "index": begin + places,
        "task_index": np.zeros(frames.count, int),
    }


def _write_frames(file: Path, table: dict[str, NDArray]) -> None:
    import pyarrow
    from pyarrow import parquet

    arrays = {
        name: pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(values.ravel()), values.shape[1])
        if values.ndim == 2
        else pyarrow.array(values)
        for name, values in table.items()
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pyarrow.table(arrays), file)


def _film(file: Path, pictures: list[tuple[str, bytes]], fps: int) -> NDArray[np.float64]:
    """Write a film; return (n, 4, 3) of its pictures: least and greatest colour, mean, mean square, from 0 to 1."""
    file.parent.mkdir(parents=True, exist_ok=True)
    found = []
    with FilmFile(file, fps) as film:
        for one in pictures:
            pixels = pixels_of(one)
            film.add(pixels)
            rows = pixels.reshape(-1, 3) / 255.0
            found.append([rows.min(axis=0), rows.max(axis=0), rows.mean(axis=0), (rows**2).mean(axis=0)])
    return np.asarray(found)


def _statistics(values: NDArray) -> dict[str, Any]:
    """Return what learning scales by: of vectors (n, k) or numbers (n,), or of a film, (n, 4, 3) as `_film` has it.

    Those of films have the shape (3, 1, 1).
    """
    count = [len(values)]
    if values.ndim == 3:
        least, most, mean, square = values[:, 0].min(0), values[:, 1].max(0), values[:, 2].mean(0), values[:, 3].mean(0)
        found = {"min": least, "max": most, "mean": mean, "std": np.sqrt(np.maximum(square - mean**2, 0.0))}
        return {**{name: one.reshape(3, 1, 1).tolist() for name, one in found.items()}, "count": count}
    rows = values.reshape(len(values), -1).astype(float)
    found = {"min": rows.min(axis=0), "max": rows.max(axis=0), "mean": rows.mean(axis=0), "std": rows.std(axis=0)}
    return {**{name: one.tolist() for name, one in found.items()}, "count": count}


def _write_meta(
    folder: Path, first: Episode, written: list[Frames], rows: list[dict[str, Any]], total: int, fps: int, task: str
) -> None:
    import pyarrow
    from pyarrow import parquet

    coordinates = [*first.joints, *sorted(first.signals)]
    names = {STATE: coordinates, ACTION: coordinates, TOOL: list(POSE)}
    features: dict[str, Any] = {
        name: {"dtype": "float32", "shape": [len(words)], "names": words} for name, words in names.items()
    }
    for camera, pictures in written[0].pictures.items():
        height, width, _ = pixels_of(pictures[0]).shape
        height, width = height - height % 2, width - width % 2
        features[IMAGE + camera] = {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                **{"video.height": height, "video.width": width, "video.channels": 3, "video.fps": fps},
                **{"video.pix_fmt": "yuv420p", "video.codec": "h264", "video.is_depth_map": False, "has_audio": False},
            },
        }
    features["timestamp"] = {"dtype": "float32", "shape": [1], "names": None}
    features |= {name: {"dtype": "int64", "shape": [1], "names": None} for name in _COUNTED}
    about = {
        **{"codebase_version": VERSION, "robot_type": first.robot, "fps": fps, "splits": {"train": f"0:{len(rows)}"}},
        **{"total_episodes": len(rows), "total_frames": total, "total_tasks": 1, "chunks_size": CHUNK},
        **{"data_files_size_in_mb": 100, "video_files_size_in_mb": 200},
        **{"data_path": DATA, "video_path": FILMS if written[0].pictures else None, "features": features},
    }
    (folder / INFO).parent.mkdir(parents=True, exist_ok=True)
    (folder / INFO).write_text(json.dumps(about, indent=4))
    # A table of pandas, whose index are the tasks.
    column = {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64"}
    index = {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object"}
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": [column, index], "pandas_version": "2.0.0"}
    tasks = pyarrow.table({"task_index": pyarrow.array([0]), "task": [task]})
    parquet.write_table(tasks.replace_schema_metadata({"pandas": json.dumps(pandas)}), folder / TASKS)
    file = folder / EPISODES.format(chunk_index=0, file_index=0)
    file.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pyarrow.Table.from_pylist(rows), file)
