"""Files of joint trajectories, read: what they say, and where what is wrong with them stands."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError
from virtualrobot.robots.trajectory_file import Joints, Samples, read, text_of

NAMES = ["base", "elbow", "slide/x"]


def of_count(count: int) -> list[str]:
    if count != len(NAMES):
        raise InvalidArgumentError(f"{count} values for the robot 'arm': it has {len(NAMES)} joints")
    return NAMES


def samples(text: str, file: str = "sweep.csv") -> Samples:
    return read(text, file, Joints("arm", NAMES, of_count))


def test_a_table_names_its_columns() -> None:
    read = samples("time,elbow,base,x,y,z,tcp_speed\n0,0.5,1,9,9,9,9\n0.25,0.6,2,9,9,9,9\n")
    assert read.joint_names == ["elbow", "base"]
    np.testing.assert_array_equal(read.times, [0.0, 0.25])
    np.testing.assert_array_equal(read.positions, [[0.5, 1.0], [0.6, 2.0]])
    assert read.velocities is None


def test_times_are_counted_from_the_first_sample() -> None:
    # A recording: its columns are of several robots, and begin when it began.
    head = "time [s],tick,arm/base/position [rad],arm/base/velocity [rad/s],other/base/position [rad]"
    read = samples(f"{head},arm/slide/x/position [m]\n12.5,1,0.1,7,7,0.3\n13,2,0.2,7,7,0.4\n")
    assert read.joint_names == ["base", "slide/x"]
    np.testing.assert_array_equal(read.times, [0.0, 0.5])
    np.testing.assert_array_equal(read.positions, [[0.1, 0.3], [0.2, 0.4]])


def test_units_and_commas_of_spreadsheets() -> None:
    read = samples("time [s];base [deg];slide/x [mm]\n0;90;1,5\n\n1,5;-180;2\n")
    np.testing.assert_allclose(read.times, [0.0, 1.5])
    np.testing.assert_allclose(read.positions, [[math.pi / 2, 0.0015], [-math.pi, 0.002]])


def test_numbers_alone_are_all_joints_in_order() -> None:
    read = samples("0,1,2,3\n1,4,5,6")
    assert read.joint_names == NAMES
    np.testing.assert_array_equal(read.positions, [[1, 2, 3], [4, 5, 6]])


def test_an_object_has_the_fields_of_the_contract() -> None:
    said = {"joint_names": ["elbow"], "times": [1, 2], "positions": [[0.5], [1]], "velocities": [[0], [0.0]]}
    read = samples(json.dumps(said), "sweep.json")
    assert read.joint_names == ["elbow"]
    np.testing.assert_array_equal(read.times, [0.0, 1.0])
    np.testing.assert_array_equal(read.positions, [[0.5], [1.0]])
    assert read.velocities is not None and not read.velocities.any()
    assert samples('\n {"times": [0, 1], "positions": [[1, 2, 3], [4, 5, 6]]}').joint_names == NAMES


def test_segments_keep_their_times_and_may_have_accelerations() -> None:
    said = {"joint_names": ["elbow"], "times": [0.5], "positions": [[1.0]], "velocities": [[0.0]]}
    read = samples(json.dumps(said | {"accelerations": [[2.0]], "interpolation": "segments"}), "sweep.json")
    assert (read.interpolation, read.times.tolist()) == ("segments", [0.5])
    assert read.accelerations is not None and read.accelerations.tolist() == [[2.0]]
    with pytest.raises(MalformedFileError, match="two samples or more"):
        samples(json.dumps(said), "sweep.json")
    with pytest.raises(MalformedFileError, match="'smooth' or 'segments' belongs here, not 'cubic'"):
        samples(json.dumps(said | {"interpolation": "cubic"}), "sweep.json")


@pytest.mark.parametrize(
    ("text", "line", "column", "words"),
    [
        ("", 1, 1, "the file is empty"),
        ("time,elbow\n", 1, 1, "two samples or more, and here is 0"),
        ("time,elbow\n0,1\n", 1, 1, "two samples or more, and here is 1"),
        ("time,elbow\n0,1\n1,abc\n", 3, 2, "(elbow): 'abc' is no number"),
        ("time,elbow\n0,1\n1,\n", 3, 2, "a number is missing"),
        ("time,elbow\n0,nan\n1,2\n", 2, 2, "nan is no finite number"),
        ("time,elbow\n0,1\n\n1,-inf\n", 4, 2, "-inf is no finite number"),
        ("time,elbow\n0,1,2\n1,2,3\n", 2, 3, "here are 3 columns, and the first line has 2"),
        ("time,elbow\n0,1\n0.5,1\n0.5,1\n", 4, 1, "0.5 s does not come after 0.5 s of line 3; times rise"),
        ("elbow,time\n0,1\n1,0\n", 3, 2, "0 s does not come after 1 s"),
        ("time,elbo\n0,1\n1,2\n", 1, 2, "'arm' has no joint 'elbo'; did you mean 'elbow'?"),
        ("time,elbow,elbow\n0,1,1\n1,2,2\n", 1, 3, "stands in column 2 already"),
        ("elbow,base\n0,1\n1,2\n", 1, 1, "no column is called 'time'"),
        ("time,x,y\n0,1,1\n1,2,2\n", 1, 1, "no column is a joint of 'arm', which has base, elbow"),
        ("time,elbow [turns]\n0,1\n1,2\n", 1, 2, "'turns' is none of rad, deg, m, mm"),
        ("0,1,2\n1,4,5\n", 1, 3, "these are a time and 2 joints: 2 values for the robot 'arm'"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table(text: str, line: int, column: int, words: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        samples(text)
    assert refused.value.message.startswith(f"sweep.csv:{line}: column {column}")
    assert words in refused.value.message
    assert refused.value.metadata["line"] == str(line)


@pytest.mark.parametrize(
    ("text", "line", "column", "words"),
    [
        ('{"times": [0, 1],\n "positions": [[1] [2]]}', 2, 20, "this is no JSON"),
        ('{"times": ' + "[" * 100_000, 1, 1, "too deep"),
        ('{"times": [0, 1]}', 1, 1, "the field 'positions' is missing"),
        ('{"times": [0, 1], "position": []}', 1, 31, "there is no field 'position'; did you mean 'positions'?"),
        ('{"times": [0],\n"positions": [[1, 2, 3]]}', 1, 11, "two samples or more"),
        ('{"times": [0, 1, 1],\n"positions": []}', 1, 18, "(times[2]): 1 s does not come after 1 s"),
        ('{"positions": [[1, 2, 3],\n  [4, NaN, 6]], "times": [0, 1]}', 2, 7, "(positions[1][1]): nan is no finite"),
        ('{"positions": [[1, 2, 3],\n  [4, 1e999, 6]], "times": [0, 1]}', 2, 7, "inf is no finite number"),
        ('{"positions": [[1, 2, 3], [4, "5", 6]], "times": [0, 1]}', 1, 31, "'5' is no number"),
        ('{"positions": [[1, 2, 3], [4, true, 6]], "times": [0, 1]}', 1, 31, "True is no number"),
        ('{"positions": [[1, 2, 3], [4, 5]], "times": [0, 1]}', 1, 27, "a row of 3 joints belongs here, not 2 values"),
        ('{"positions": [[1, 2, 3]], "times": [0, 1]}', 1, 15, "here are 1 rows, and there are 2 times"),
        ('{"positions": 5, "times": [0, 1]}', 1, 15, "a list belongs here, not 5"),
        ('{"positions": [[1], [2]], "times": [0, 1]}', 1, 15, "these are 1 joints: 1 values for the robot 'arm'"),
        ('{"joint_names": ["base", "x"], "times": [0, 1], "positions": []}', 1, 26, "no joint 'x'"),
        ('{"joint_names": ["base", "base"], "times": [0, 1], "positions": []}', 1, 26, "stands here twice"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_an_object(text: str, line: int, column: int, words: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        samples(text, "sweep.json")
    assert refused.value.message.startswith(f"sweep.json:{line}: column {column}"), refused.value.message
    assert words in refused.value.message


def test_what_can_not_be_read(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"sweep\.csv cannot be read: No such file"):
        text_of(tmp_path / "sweep.csv")
    (tmp_path / "sweep.csv").write_bytes(b"time\xff")
    with pytest.raises(MalformedFileError, match=r"no text in UTF-8: .* at byte 4"):
        text_of(tmp_path / "sweep.csv")
    (tmp_path / "sweep.csv").write_bytes(b"\xef\xbb\xbftime")  # as spreadsheets begin it
    assert text_of(tmp_path / "sweep.csv") == "time"
