"""Codes for phones and headsets: what a reader takes from them, and who is told why there is none."""

from __future__ import annotations

import re

import cv2
import numpy as np
from virtualrobot_apps.console.invitation import ALONE, NAMELESS, QUIET, Reach

PIXELS = 8
"""Pixels of a module."""


def read(svg: str) -> str:
    """Return what a code says whose dark modules are rows of horizontal strokes, by OpenCV's reader."""
    size = int(re.findall(r'viewBox="0 0 (\d+) \d+"', svg)[0])
    modules = np.full((size, size), 255, np.uint8)
    x = y = 0.0
    for command, said in re.findall(r"([Mmhz])([^Mmhz]*)", re.findall(r'stroke="#000" d="([^"]*)"', svg)[0]):
        numbers = [float(one) for one in re.findall(r"-?[\d.]+", said)]
        if command == "M":
            x, y = numbers
        elif command == "m":
            x, y = x + numbers[0], y + numbers[1]
        else:
            modules[int(y), int(x) : int(x + numbers[0])] = 0
            x += numbers[0]
    assert modules[:QUIET].min() == modules[:, -QUIET:].min() == 255
    text, *_ = cv2.QRCodeDetector().detectAndDecode(np.kron(modules, np.ones((PIXELS, PIXELS), np.uint8)))
    return text


def test_a_code_says_the_link_as_other_machines_have_it() -> None:
    reach = Reach("https://192.168.1.4:8090", signed=True)
    told = reach.invited("localhost:8090", "once")
    assert told["url"] == read(told["code"]) == "https://192.168.1.4:8090/?key=once"
    assert told["trust"] == read(told["trust_code"]) == "https://192.168.1.4:8090/authority.crt"
    # Whoever came by a name that others have, gives that.
    plain = Reach("https://192.168.1.4:8090").invited("cell.local:8090", "once")
    assert plain["url"] == "https://cell.local:8090/?key=once" and "trust" not in plain


def test_a_console_of_one_machine_says_how_others_reach_it() -> None:
    assert Reach("http://127.0.0.1:8090").invited("127.0.0.1:8090", "once") == {"fault": ALONE}
    # What others reach it by nevertheless, as a tunnel, it is reached by.
    told = Reach("http://127.0.0.1:8090").invited("tunnel.example", "once")
    assert told["url"] == "http://tunnel.example/?key=once"


def test_a_machine_without_an_address_that_is_signed_for_says_so() -> None:
    """It listens to others, who don't get here by localhost."""
    told = Reach("https://localhost:8090", signed=True, fault=NAMELESS).invited("localhost:8090", "once")
    assert set(told) == {"fault"} and "--host-name" in told["fault"] and "alone:" not in told["fault"]
    named = Reach("https://cell.local:8090", signed=True, fault=NAMELESS).invited("localhost:8090", "once")
    assert named["url"] == "https://cell.local:8090/?key=once"
