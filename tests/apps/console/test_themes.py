"""The colours of the console's page: readable in both themes by the contrast that WCAG 2.2 asks for.

Formulas and numbers: W3C, Web Content Accessibility Guidelines 2.2, relative luminance and contrast ratio; success
criteria 1.4.3 (4.5 for text) and 1.4.11 (3 for signs).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_apps import console

CSS = (Path(console.__file__).parent / "web" / "src" / "style" / "base.css").read_text("utf-8")
WORDS = ("text", "muted", "faint", "accent", "good", "warning", "bad", "x", "y", "z")
SIGNS = ("robot", "tool", "part", "sensor", "light", "danger", "marked")
GROUNDS = ("panel", "raised")


def colors(theme: str) -> dict[str, str]:
    """Return the colours of a theme by name; the light one is what differs from the dark one."""
    dark, light = (
        re.search(rf"^{re.escape(head)} {{(.*?)^}}", CSS, re.M | re.S) for head in (":root", '[data-theme="light"]')
    )
    assert dark and light
    blocks = [dark[1]] if theme == "dark" else [dark[1], light[1]]
    return {name: value for block in blocks for name, value in re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block)}


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21."""
    darker, lighter = sorted(map(luminance, (one, other)))
    return (lighter + 0.05) / (darker + 0.05)


def luminance(color: str) -> float:
    """Return the relative luminance of `#rrggbb`."""
    parts = np.array([int(color[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_black_on_white_has_the_greatest_contrast() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)  # the grey that is just too light


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_words_and_signs_can_be_read(theme: str) -> None:
    of = colors(theme)
    found = {(name, ground): contrast(of[name], of[ground]) for name in (*WORDS, *SIGNS) for ground in GROUNDS}
    found |= {(name, "selected"): contrast(of[name], of["selected"]) for name in ("text", "muted")}
    found["accent", "accent-ground"] = contrast(of["accent"], of["accent-ground"])
    faint = {pair: round(ratio, 2) for pair, ratio in found.items() if ratio < (3.0 if pair[0] in SIGNS else 4.5)}
    assert faint == {}


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("ground", ["accent-deep", "danger"])
def test_white_can_be_read_on_buttons(theme: str, ground: str) -> None:
    # The words of STOP are large and bold, for which 3 will do.
    assert contrast("#ffffff", colors(theme)[ground]) >= (3.0 if ground == "danger" else 4.5)
