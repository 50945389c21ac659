"""Gamepads: what their files mean, what is wanted by them, and SDL's own virtual one."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot.cli.gamepad import AXES, Gamepad, PadState
from virtualrobot.cli.gamepad_mapping import (
    DIRECTIONS,
    GAMEPAD,
    KEYBOARD,
    USUAL_KEYBOARD,
    Control,
    GamepadMapping,
    read_mapping,
)
from virtualrobot.cli.held_pad import FRESH_SECONDS, HeldPad
from virtualrobot.errors import MalformedFileError, MissingFileError, WrongStateError

from tests.gamepads import library, virtual_pad

NONE = (0.0, 0.0, 0.0)
MAPPING = read_mapping()


class Time:
    """Time that the test lets go by."""

    now = 10.0

    def __call__(self) -> float:
        return self.now


class Scripted:
    """A gamepad as the test says that it is."""

    name = "scripted"

    def __init__(self) -> None:
        """Begin with nothing pressed."""
        self.state: PadState | None = PadState()

    def read(self) -> PadState:
        if self.state is None:
            raise WrongStateError("the gamepad scripted has gone")
        return self.state

    def hold(self, *buttons: str, **axes: float) -> None:
        self.state = PadState(axes, frozenset({MAPPING.hold, *buttons}))


def test_a_gamepad_shakes_as_strongly_as_it_is_told() -> None:
    with virtual_pad() as pad, Gamepad() as gamepad:
        for strength in (0.5, 1.0, 0.0):
            gamepad.feel(strength)
        assert pad.felt == [(32768, 32768), (65535, 65535), (0, 0)]


@pytest.mark.parametrize(
    ("force", "said"),
    [
        ("{sensor: wrist, full: 0}", "force.full is 0; it must be a number of newtons above 0"),
        ("{full: 10}", "force.sensor is None; it must be the name of a force and torque sensor"),
        ("{sensor: wrist, full: 10, axis: z}", "no force.axis; it has sensor, full"),
    ],
)
def test_a_force_that_cannot_be_felt_is_refused(tmp_path: Path, force: str, said: str) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(f"{{schema_version: 1, hold: a, force: {force}}}")
    with pytest.raises(MalformedFileError, match=said):
        read_mapping(file)


def held(pad: Scripted, clock: Time, mapping: GamepadMapping = MAPPING) -> HeldPad:
    return HeldPad(pad, mapping, [mapping.drive.get(name) for name in DIRECTIONS], (0.4, 0.4, 0.8), clock)


def test_nothing_is_wanted_unless_the_dead_mans_button_is_held() -> None:
    pad, time = Scripted(), Time()
    one = held(pad, time)
    assert one.wanted() == NONE and not one.is_held
    pad.state = PadState({"left_y": -1.0, "right_x": 1.0})
    one.read()
    assert one.wanted() == NONE
    pad.hold(left_y=-1.0, right_x=1.0)
    one.read()
    # A stick that is pushed away is ahead, one to the right turns to the right.
    assert one.wanted() == (0.4, 0.0, -0.8) and one.is_held
    pad.hold("dpad_left", left_y=1.0)
    one.read()
    assert one.wanted() == (-0.4, 0.4, 0.0)
    pad.state = PadState({"left_y": 1.0})
    one.read()
    assert one.wanted() == NONE


def test_a_state_that_is_old_counts_no_more() -> None:
    pad, time = Scripted(), Time()
    one = held(pad, time)
    pad.hold(left_y=-1.0)
    one.read()
    time.now += FRESH_SECONDS - 0.01
    assert one.wanted() == (0.4, 0.0, 0.0)
    time.now += 0.02
    assert one.wanted() == NONE and not one.is_held


def test_a_gamepad_that_has_gone_wants_nothing() -> None:
    pad = Scripted()
    one = held(pad, Time())
    pad.hold(left_y=-1.0)
    one.read()
    pad.state = None
    with pytest.raises(WrongStateError, match="has gone"):
        one.read()
    assert one.wanted() == NONE


def test_buttons_slow_down_and_speed_up_once_for_each_press() -> None:
    pad = Scripted()
    one = held(pad, Time())
    for _ in range(3):
        pad.hold(MAPPING.slower, left_y=-1.0)
        one.read()
        one.read()
        pad.hold(left_y=-1.0)
        one.read()
    assert one.share == pytest.approx(0.7)
    assert one.wanted() == pytest.approx((0.28, 0.0, 0.0))
    pad.hold(MAPPING.faster)
    one.read()
    assert one.share == pytest.approx(0.8)


@pytest.mark.parametrize(
    ("moved", "value"), [(0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.6, 0.5), (1.0, 1.0), (-1.0, -1.0)]
)
def test_a_stick_grows_from_the_edge_of_its_dead_zone_to_1(moved: float, value: float) -> None:
    state = PadState({"left_x": moved})
    assert Control("left_x").value(state, 0.2) == pytest.approx(value)
    assert Control("left_x", -1.0).value(state, 0.2) == pytest.approx(-value)
    assert Control("right_x").value(state, 0.2) == 0.0


def test_the_usual_mapping_is_whole() -> None:
    assert set(MAPPING.drive) == set(DIRECTIONS)
    assert list(MAPPING.jog) == ["1", "2", "3", "4", "5", "6"]
    assert MAPPING.hold == "right_shoulder" and MAPPING.dead_zone == 0.15


def test_a_file_says_what_is_meant(tmp_path: Path) -> None:
    file = tmp_path / "pad.yaml"
    file.write_text("schema_version: 1\nhold: y\ndead_zone: 0\njog: {elbow: -right_y, 2: [a, b]}\n")
    mapping = read_mapping(file)
    assert mapping == GamepadMapping(
        "y", 0.0, {}, {"elbow": Control("right_y", -1.0), "2": Control(buttons=("a", "b"))}
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hold: a", "schema_version is None; it must be 1"),
        ("schema_version: 1", "hold is None; it must be a button: a, b"),
        ("{schema_version: 1, hold: left_x}", "hold is 'left_x'; it must be a button"),
        ("{schema_version: 1, hold: a, dead_zone: 2}", "dead_zone is 2; it must be a number from 0 to 0.9"),
        ("{schema_version: 1, hold: a, drive: {up: left_y}}", "no drive.up; it has forward, left, turn"),
        ("{schema_version: 1, hold: a, drive: {turn: a}}", "drive.turn is 'a'; it must be an axis, such as -left_y"),
        ("{schema_version: 1, hold: a, jog: [left_x]}", r"jog is \['left_x'\]; it must be fields"),
        ("{schema_version: 1, hold: a, jog: {1: [a, 7]}}", "jog.1 is 7; it must be a button"),
        ("{schema_version: 1, hold: a, rumble: 1}", "no 'rumble'; a mapping has schema_version, hold"),
        ("{schema_version: 1", "is not YAML"),
    ],
)
def test_a_file_that_makes_no_sense_is_refused_by_its_place(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "pad.yaml"
    file.write_text(text)
    with pytest.raises(MalformedFileError, match=said):
        read_mapping(file)
    with pytest.raises(MissingFileError, match="no mapping"):
        read_mapping(tmp_path / "none.yaml")


def test_sdl_tells_sticks_buttons_and_that_it_has_gone() -> None:
    with virtual_pad() as virtual, Gamepad() as pad:
        assert pad.name
        assert pad.read() == PadState(dict.fromkeys(AXES, 0.0), frozenset())
        virtual.move(left_y=-1.0, right_x=0.5)
        virtual.press("a", "right_shoulder", "dpad_left")
        state = pad.read()
        assert state.axes["left_y"] == -1.0
        assert state.axes["right_x"] == pytest.approx(0.5, abs=1e-4)
        assert state.buttons == {"a", "right_shoulder", "dpad_left"}
        virtual.press("a", down=False)
        assert pad.read().buttons == {"right_shoulder", "dpad_left"}
        virtual.unplug()
        with pytest.raises(WrongStateError, match="has gone"):
            pad.read()


def test_a_machine_without_a_gamepad_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library(), "SDL_NumJoysticks", lambda: 0)
    with pytest.raises(WrongStateError, match="no gamepad is connected"):
        Gamepad()


def test_a_keyboard_has_keys_alone_and_a_mapping_may_move_a_view(tmp_path: Path) -> None:
    usual = read_mapping(USUAL_KEYBOARD, KEYBOARD)
    assert usual.hold == "shift" and usual.jog["6"] == Control(buttons=("6", "y"))
    file = tmp_path / "mapping.yaml"
    file.write_text("{schema_version: 1, hold: a, camera: {turn: left_x, up: [x, y]}}")
    assert read_mapping(file).camera == {"turn": Control("left_x"), "up": Control(buttons=("x", "y"))}
    for text, device, said in (
        ("camera: {roll: left_x}", GAMEPAD, "no camera.roll; it has right, up, nearer, turn, tilt"),
        ("jog: {1: q}", KEYBOARD, "jog.1 is 'q'; it must be two keys, such as"),
        ("jog: {1: [1, f1]}", KEYBOARD, "jog.1 is 'f1'; it must be a button"),
    ):
        file.write_text(f"{{schema_version: 1, hold: a, {text}}}")
        with pytest.raises(MalformedFileError, match=said):
            read_mapping(file, device)
