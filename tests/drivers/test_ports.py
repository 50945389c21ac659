"""`virtualrobot driver ports`."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo
from virtualrobot.cli import cli


def test_ports_are_told_in_order_with_what_hangs_on_them(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [ListPortInfo("/dev/ttyUSB1"), ListPortInfo("/dev/ttyACM0")]
    found[0].description = "USB Serial Converter"
    found[1].description = "Board in FS mode"
    monkeypatch.setattr(list_ports, "comports", lambda: found)
    result = CliRunner().invoke(cli, ["driver", "ports"])
    assert result.output == "/dev/ttyACM0  Board in FS mode\n/dev/ttyUSB1  USB Serial Converter\n"
    monkeypatch.setattr(list_ports, "comports", list)
    assert CliRunner().invoke(cli, ["driver", "ports"]).output == "this machine has no serial port\n"
