"""Space mice: what their reports mean, which devices are some, and what the usual mapping makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot.cli.gamepad_mapping import SPACE_MOUSE, TOOL, USUAL_SPACE_MOUSE, read_mapping
from virtualrobot.cli.held_pad import HeldPad
from virtualrobot.cli.space_mouse import SpaceMouse, within
from virtualrobot.errors import MalformedFileError, WrongStateError

from tests.space_mice import INFO, FakeHid, motion, pressed, rotation, translation

MAPPING = read_mapping(USUAL_SPACE_MOUSE, SPACE_MOUSE)


def test_reports_tell_axes_and_buttons_until_others_come() -> None:
    hid = FakeHid()
    with SpaceMouse(hid) as mouse:
        assert (hid.opened, mouse.name) == (b"/dev/hidraw7", "SpaceMouse Compact")
        assert not any(mouse.read().axes.values())
        hid.send(translation(350, -175, 35), rotation(0, 700, -350), pressed(0b10))
        state = mouse.read()
        # 350 counts are the whole way; what is more counts as that.
        assert state.axes == {"x": 1.0, "y": -0.5, "z": 0.1, "rx": 0.0, "ry": 1.0, "rz": -1.0}
        assert state.buttons == {"right"}
        assert mouse.read() == state  # nothing is reported while nothing changes
        hid.send(translation())
        assert mouse.read().axes["x"] == 0.0 and mouse.read().axes["ry"] == 1.0
    assert hid.is_closed


def test_newer_devices_tell_all_axes_in_one_report() -> None:
    hid = FakeHid()
    with SpaceMouse(hid) as mouse:
        # As a SpaceMouse Wireless sends it: number 1, then six numbers of two bytes, the lower one first.
        hid.send(bytes.fromhex("01 5e 01 a2 fe 00 00 af 00 51 ff 01 00"))
        assert [round(350 * value) for value in mouse.read().axes.values()] == [350, -350, 0, 175, -175, 1]
        hid.send(motion(0, 0, 0, 0, 0, 0), b"\x01\x05", b"\x17\x64")  # one that is too short, and one of the battery
        assert not any(mouse.read().axes.values())


def test_the_first_multi_axis_controller_is_taken() -> None:
    keyboard = {**INFO, "vendor_id": 0x046D, "product_id": 0xC31C, "usage": 6, "path": b"keyboard"}
    mouse = {**INFO, "product_id": 0xC650, "usage": 2, "path": b"an ordinary mouse of the same maker"}
    old = {**INFO, "vendor_id": 0x046D, "product_id": 0xC626, "usage_page": 0, "usage": 0, "path": b"navigator"}
    hid = FakeHid(keyboard, mouse, old)
    with SpaceMouse(hid):
        assert hid.opened == b"navigator"
    with pytest.raises(WrongStateError, match="no space mouse is connected"):
        SpaceMouse(FakeHid(keyboard, mouse))
    with pytest.raises(WrongStateError, match=r"SpaceMouse Compact cannot be opened: permission denied; .* udev"):
        SpaceMouse(FakeHid(refuses="permission denied"))


def test_the_library_itself_is_asked_for_devices() -> None:
    hid = pytest.importorskip("hid", reason="hidapi is not installed: pip install hidapi")
    if any(one["vendor_id"] == INFO["vendor_id"] for one in hid.enumerate()):
        with SpaceMouse() as mouse:
            assert mouse.read().buttons == set()
    else:
        with pytest.raises(WrongStateError, match="no space mouse is connected"):
            SpaceMouse()


def test_one_that_is_pulled_out_has_gone() -> None:
    hid = FakeHid()
    with SpaceMouse(hid) as mouse:
        hid.is_there = False
        with pytest.raises(WrongStateError, match="SpaceMouse Compact has gone"):
            mouse.read()


def test_the_usual_mapping_looks_at_the_arm_from_behind() -> None:
    hid = FakeHid()
    with SpaceMouse(hid) as mouse:
        held = HeldPad(mouse, MAPPING, [MAPPING.tool.get(name) for name in TOOL], [0.3] * 3 + [0.6] * 3, lambda: 0.0)
        hid.send(translation(0, -350, 0))
        held.read()
        assert held.wanted() == (0.0,) * 6 and not held.is_held  # the dead man's button is not
        hid.send(pressed(1))
        held.read()
        assert held.wanted() == (0.3, 0.0, 0.0, 0.0, 0.0, 0.0)  # pushed away is ahead
        hid.send(translation(-350, 0, 0))
        held.read()
        assert held.wanted()[1] == 0.3
        hid.send(translation(0, 0, -350), rotation(0, 0, -350))  # lifted, and turned to the left as seen from above
        held.read()
        assert held.wanted() == (0.0, 0.0, 0.3, 0.0, 0.0, 0.6)
        hid.send(translation(0, 0, -35), rotation(0, 34, 0))  # within the dead zone
        held.read()
        assert not any(held.wanted())


def test_a_twist_is_shortened_in_its_direction() -> None:
    assert within((0.3, 0.4, 0.0, 0.0, 0.0, 0.1), 0.25, 0.6) == pytest.approx((0.15, 0.2, 0.0, 0.0, 0.0, 0.1))
    assert within((0.0, 0.0, 0.0, 0.0, 3.0, 4.0), 0.25, 1.0) == pytest.approx((0.0, 0.0, 0.0, 0.0, 0.6, 0.8))
    assert within((0.0,) * 6, 0.25, 1.0) == (0.0,) * 6


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "{schema_version: 1, hold: left, tool: {vx: left_x}}",
            "tool.vx is 'left_x'; .* such as -y, .* axes are x, y, z",
        ),
        ("{schema_version: 1, hold: a}", "hold is 'a'; it must be a button: left, right"),
        ("{schema_version: 1, hold: left, tool: {up: z}}", "no tool.up; it has vx, vy, vz, wx, wy, wz"),
        ("{schema_version: 1, hold: left, tool: {vx: x}, jog: {1: y}}", "both jog and tool"),
    ],
)
def test_a_mapping_that_cannot_be_is_refused_by_field(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(text)
    with pytest.raises(MalformedFileError, match=said):
        read_mapping(file, SPACE_MOUSE)
