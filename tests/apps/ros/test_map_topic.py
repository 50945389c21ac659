"""A map as `nav_msgs/OccupancyGrid`: a file as ROS's map_server has it, told to roslibpy."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot import Client
from virtualrobot.errors import MalformedFileError, MissingFileError
from virtualrobot_apps.bridges.ros.bridge import RosBridge

from tests.apps.ros.bridges import Heard, bridge, roslibpy_client
from tests.waiting import until

DESCRIPTION = """image: floor.pgm
mode: trinary
resolution: 0.05
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def write(folder: Path, *rows: tuple[int, ...]) -> Path:
    """Write a map: black (0) is occupied, white (254) free, grey (205) unknown; its first row is the upper one."""
    head = f"P5\n{len(rows[0])} {len(rows)}\n255\n".encode()
    (folder / "floor.pgm").write_bytes(head + bytes(pixel for row in rows for pixel in row))
    file = folder / "floor.yaml"
    file.write_text(DESCRIPTION, "utf-8")
    return file


def test_a_map_is_told_to_those_who_come_later_and_anew_once_it_is_another(client: Client, tmp_path: Path) -> None:
    file = write(tmp_path, (0, 205, 254), (254, 254, 0))
    lines = RosBridge(client, [], floor=file).check()
    assert any(line.split() == ["/map", "nav_msgs/msg/OccupancyGrid", "of", str(file)] for line in lines)
    with bridge(client, floor=file) as (url, said), roslibpy_client(url) as ros:
        heard = Heard(ros, "/map", "nav_msgs/OccupancyGrid")
        told = heard.next()
        assert told["header"]["frame_id"] == "map"
        info = told["info"]
        assert (info["width"], info["height"], info["origin"]["position"]) == (3, 2, {"x": -1.0, "y": 2.0, "z": 0.0})
        assert info["resolution"] == pytest.approx(0.05, rel=1e-7)  # float32
        # From the lower left corner on, row by row (nav_msgs/OccupancyGrid); values of nav2_map_server's `trinary`.
        assert told["data"] == [0, 0, 100, 100, -1, 0]

        write(tmp_path, (254, 254), (0, 254), (254, 254))
        heard.until(lambda one: one["data"] == [0, 0, 100, 0, 0, 0])
        (tmp_path / "floor.pgm").write_bytes(b"P6")
        until(lambda: any(words.startswith("/map: ") and "is no picture in PGM" in words for words in said))
        assert Heard(ros, "/map", "nav_msgs/OccupancyGrid").next()["info"]["height"] == 3  # the last one stays


def test_what_is_no_map_is_refused(client: Client, tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="there is no map"):
        RosBridge(client, [], floor=tmp_path / "none.yaml").check()
    (tmp_path / "odd.yaml").write_text("image: floor.pgm\n", "utf-8")
    with pytest.raises(MalformedFileError, match="it lacks resolution, origin"):
        RosBridge(client, [], floor=tmp_path / "odd.yaml").run()
