"""Pictures, films, picking and measuring by the client library and the command line."""

from __future__ import annotations

import io
import itertools
import math
from pathlib import Path

import av
import numpy as np
import pytest
import virtualrobot
from PIL import Image
from virtualrobot import Client, InvalidArgumentError, Robot, UnknownNameError
from virtualrobot.view.film import FilmFile

from tests.api.client.conftest import Run

EYE = ([0.0, -4.0, 0.0], [0.0, 0.0, 0.0])
SIZE = (160, 120)


@pytest.fixture
def ball(client: Client) -> str:
    """Return the name of a red ball in the middle, before a plain background."""
    client.view.background, client.view.grid = "white", False
    client.scene.add_part("ball", virtualrobot.sphere(0.5, color=[0.8, 0.2, 0.2]))
    return "ball"


def is_red(pixels: np.ndarray, row: int, column: int) -> bool:
    red, green, _ = pixels[row, column].astype(int)
    return bool(red > 2 * green)


def frames_of(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


@pytest.mark.long
def test_a_model_has_a_picture(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "arm.png"
    assert run("capture", str(file), "--model", "ur5e") == f"{file}: 208x156, the model ur5e\n"
    with Image.open(file) as picture:
        assert picture.size == (208, 156)
    assert "--model is alone" in run("capture", str(tmp_path / "arm.jpg"), "--model", "ur5e", code=2)


def test_a_capture_is_a_picture_with_its_pixels_or_a_file(client: Client, ball: str, tmp_path: Path) -> None:
    raw = client.view.capture(EYE, size=SIZE, format="raw")
    assert raw.pixels.shape == (120, 160, 3)
    assert is_red(raw.pixels, 60, 80)
    assert raw.pixels[0, 0].tolist() == [255, 255, 255]
    png = client.view.capture(EYE, size=SIZE)
    png.save(tmp_path / "a.png")
    assert (np.asarray(Image.open(tmp_path / "a.png")) == raw.pixels).all()
    jpeg = client.view.capture(EYE, size=SIZE, format="jpg")
    assert Image.open(io.BytesIO(jpeg.image)).format == "JPEG"
    with pytest.raises(InvalidArgumentError, match="png"):
        jpeg.save(tmp_path / "b.png")
    with pytest.raises(InvalidArgumentError, match="raw"):
        _ = png.pixels
    largest = client.view.capture(EYE, size=(4096, 2160), format="raw")
    assert largest.pixels.shape == (2160, 4096, 3), "26 MB in one answer"
    narrow = client.view.capture((*EYE, 0.2), size=SIZE, format="raw")
    assert is_red(narrow.pixels, 2, 80), "the ball is higher than it"


@pytest.mark.parametrize(
    "bad",
    [{"format": "bmp"}, {"size": (-1, 2)}, {"size": 3}, {"camera": (1, 2, 3, 4)}, {"camera": ([0, 0], [0, 0, 0])}],
)
def test_what_is_no_picture_is_refused_before_it_is_asked_for(client: Client, bad: dict) -> None:
    with pytest.raises(InvalidArgumentError):
        client.view.capture(**bad)


@pytest.mark.long
def test_a_recording_has_each_picture_and_can_be_left(client: Client, ball: str) -> None:
    client.clock.set_stepped()
    with client.view.record(EYE, size=SIZE, rate=50.0, duration=0.1) as recording:
        first = next(recording)
        client.clock.step(30)
        pictures = [first, *recording]
    times = [picture.simulation_time - first.simulation_time for picture in pictures]
    np.testing.assert_allclose(times, [0.0, 0.02, 0.04, 0.06, 0.08], atol=1e-9)
    assert [picture.number for picture in pictures] == [0, 1, 2, 3, 4]
    assert (first.width, first.height, first.format) == (160, 120, "jpeg")
    with client.view.record(rate=250.0) as endless:
        client.clock.step(10)
        assert len(list(itertools.islice(endless, 5))) == 5
    assert (next(client.view.record()).width, client.clock.mode) == (1280, "stepped")


@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_a_film_has_all_its_pictures(client: Client, ball: str, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"film{ending}"
    told: list[int] = []
    count = client.view.film(
        path, EYE, duration=0.4, size=SIZE, rate=25.0, told=lambda picture: told.append(picture.number)
    )
    frames = frames_of(path)
    assert (count, len(frames), told) == (10, 10, list(range(10)))
    assert frames[0].shape == (120, 160, 3)
    assert is_red(frames[-1], 60, 80)
    assert (frames[0][0, 0] > 240).all(), "before white"


@pytest.mark.long
def test_a_film_is_made_while_the_program_goes_on(client: Client, iiwa: Robot, tmp_path: Path) -> None:
    """It has a picture for each step of time from its start to its end, though drawing takes longer."""
    path = tmp_path / "move.mp4"
    film = client.view.start_film(path, size=(640, 480), rate=50.0)
    begin = client.clock.read().stamp.simulation_time
    iiwa.move_joints([0.3, 0.2, 0, -0.3, 0, 0.2, 0])
    end = client.clock.read().stamp.simulation_time
    count = film.finish()
    assert (end - begin) * 50.0 - 1 <= count == len(frames_of(path))


def test_a_film_that_is_broken_off_opens(client: Client, ball: str, tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"

    def interrupt(picture: object) -> None:
        if picture.number == 4:  # pyright: ignore[reportAttributeAccessIssue]
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        client.view.film(path, EYE, size=(33, 31), told=interrupt)
    frames = frames_of(path)
    assert (len(frames), frames[0].shape) == (5, (30, 32, 3)), "of an odd size all but the last row and column"


def test_what_is_no_film_is_refused(client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidArgumentError, match="mp4"):
        client.view.film(tmp_path / "film.avi")
    with pytest.raises(UnknownNameError):
        client.view.film(tmp_path / "film.mp4", "nobody")
    assert list(tmp_path.iterdir()) == [], "no empty file is left"
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(virtualrobot.WrongStateError, match=r"virtualrobot\[video\]"):
        FilmFile(tmp_path / "film.mp4", 25.0)


def test_picking_and_measuring(client: Client, ball: str) -> None:
    found = client.view.pick(79.5, 59.5, EYE, size=SIZE)
    assert (found.node, found.distance) == ("ball", pytest.approx(3.5, abs=1e-5))
    np.testing.assert_allclose(found.normal, [0.0, -1.0, 0.0], atol=1e-4)
    np.testing.assert_allclose(found.color, [0.8, 0.2, 0.2], atol=0.003)
    nothing = client.view.pick(0, 0, EYE, size=SIZE)
    assert (nothing.node, nothing.distance) == ("", np.inf)
    assert np.isnan(nothing.point).all()
    places = ("ball", found.node_point), ("world", [0.0, 0.0, 0.0])
    assert client.view.measure(*places).distance == pytest.approx(0.5, abs=1e-5)
    watch = client.view.watch_measure(*places)
    assert next(watch).distance == pytest.approx(0.5, abs=1e-5)
    client.view.measurements = {"gap": places}
    ((first, second),) = client.view.measurements.values()
    assert (first[0], second[0]) == ("ball", "world")
    np.testing.assert_allclose(np.asarray(first[1]), found.node_point)
    with pytest.raises(InvalidArgumentError, match="a node's name and a point"):
        client.view.measure("ball", "world")  # pyright: ignore[reportArgumentType] that is the point


def test_the_command_line_takes_pictures_and_films(run: Run, client: Client, ball: str, tmp_path: Path) -> None:
    still, film = tmp_path / "a.png", tmp_path / "a.mp4"
    view = "--from", "0,-4,0", "--size", "160x120"
    assert run("capture", str(still), *view).startswith(f"{still}: 160x120, at ")
    assert is_red(np.asarray(Image.open(still)), 60, 80)
    assert run("record", str(film), "--seconds", "0.2", "--fps", "50", *view) == f"{film}: 10 pictures, 0.20 s\n"
    assert len(frames_of(film)) == 10
    first = run("pixel", "79.5", "59.5", *view).splitlines()[0]
    assert first == "ball, 3.500 m from the eye, of the colour #cc3333"
    assert run("pixel", "0", "0", *view) == "nothing\n"
    assert run("measure", "ball:0,0,0.5", "world") == "0.5000 m from 0.0000 0.0000 0.5000 to 0.0000 0.0000 0.0000\n"
    assert "nobody" in run("capture", str(still), "--camera", "nobody", code=1)
    assert ".png" in run("capture", str(tmp_path / "a.bmp"), code=1)
    for option in ("--fps", "--seconds"):
        assert "not in the range x>0" in run("record", str(film), option, "0", code=2)
    assert "there is no folder" in run("record", str(tmp_path / "none" / "a.mp4"), code=1)
    for option in ("--fps", "--seconds"):
        assert "no finite number" in run("record", str(film), option, "nan", code=2)


@pytest.mark.parametrize(
    ("name", "rate"),
    [("a.mp4", 0.0), ("a.mp4", 1e-9), ("a.mp4", math.nan), ("a.mp4", math.inf), ("a.mp4", -1.0), ("a.gif", 250.0)],
)
def test_a_film_that_cannot_have_its_rate_is_refused(tmp_path: Path, name: str, rate: float) -> None:
    with pytest.raises(InvalidArgumentError, match=f"not {rate:g}"):
        FilmFile(tmp_path / name, rate)


@pytest.mark.parametrize(("name", "rate"), [("a.mp4", 0.01), ("a.mp4", 1000.0), ("a.gif", 0.01), ("a.gif", 100.0)])
def test_a_film_has_its_rate(tmp_path: Path, name: str, rate: float) -> None:
    with FilmFile(tmp_path / name, rate) as film:
        for shade in (0, 128, 255):
            film.add(np.full((2, 2, 3), shade, np.uint8))
    with av.open(str(tmp_path / name)) as written:
        times = [frame.time for frame in written.decode(video=0)]
    np.testing.assert_allclose(times, np.arange(3) / rate, rtol=1e-6)


def test_an_mp4_of_one_pixel_is_refused(tmp_path: Path) -> None:
    with FilmFile(tmp_path / "a.mp4", 25.0) as film, pytest.raises(InvalidArgumentError, match="2 pixels"):
        film.add(np.zeros((48, 1, 3), np.uint8))
