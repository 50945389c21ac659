"""Modelled solids: volumes and places by formula, refusals by the place in the file."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_plugins.importers.solid.importer import SolidImporter
from virtualrobot_sdk.errors import ArgumentError

from tests.unit.plugins.importers.reading import area, bounds, broken, meshes, refusal, volume

FINE = "tolerance: 1.0e-6\n"
"""Round things have 360 sides; a circle of n sides inside has n/2 sin(2 pi/n) r^2."""

ROUND = 360.0 / 2.0 * math.sin(2.0 * math.pi / 360.0)
"""Area of a disc of radius 1 as it is made; pi but for 5e-5."""


def made(text: str) -> list[Submesh]:
    return meshes(SolidImporter(), text, "thing.solid")


def refused(text: str) -> str:
    said = refusal(SolidImporter(), text, "folder/thing.solid")
    assert said.startswith("thing.solid: ") or said.startswith("thing.solid:")
    return said.partition(": ")[2]


@pytest.mark.parametrize(
    ("text", "cubic_meters"),
    [
        ("solid: {box: {size: [0.1, 0.2, 0.3]}}", 0.006),
        (FINE + "solid: {cylinder: {radius: 0.1, length: 0.5}}", ROUND * 0.01 * 0.5),
        (FINE + "solid: {cone: {radius: 0.1, length: 0.3}}", ROUND * 0.01 * 0.3 / 3.0),
        # A frustum: h/3 (A + a + sqrt(A a)).
        (FINE + "solid: {cone: {radius: 0.2, length: 0.3, top: 0.1}}", ROUND * (0.04 + 0.01 + 0.02) * 0.1),
        ("solid: {extrude: {profile: [[0, 0], [0.2, 0], [0, 0.1]], height: 0.5}}", 0.005),
        # Either way round, and with a hole.
        (
            "solid: {extrude: {profile: {polygon: {points: [[0, 1], [1, 1], [1, 0], [0, 0]], holes: "
            "[[[0.2, 0.2], [0.4, 0.2], [0.4, 0.4], [0.2, 0.4]]]}}, height: 0.5}}",
            0.48,
        ),
        # A pyramid whose top is a point, and one that is cut off at half its height.
        ("solid: {extrude: {profile: {rectangle: {size: [1, 1]}}, height: 0.6, top: 0.0}}", 0.2),
        ("solid: {extrude: {profile: {rectangle: {size: [1, 1]}}, height: 0.3, top: 0.5}}", 0.3 / 3.0 * 1.75),
        # Pappus: a square of 0.1 turned about z at 0.3, as its circle is made.
        (FINE + "solid: {lathe: {profile: {rectangle: {size: [0.1, 0.1], center: [0.3, 0]}}}}", 2 * ROUND * 0.003),
        (
            FINE + "solid: {lathe: {profile: {rectangle: {size: [0.1, 0.1], center: [0.3, 0]}}, angle: 1.5707963}}",
            2 * ROUND * 0.003 / 4.0,
        ),
        ("solid: {difference: [{box: {size: [1, 1, 1]}}, {box: {size: [0.5, 0.5, 2]}}]}", 0.75),
        ("solid: {intersection: [{box: {size: [1, 1, 1]}}, {box: {size: [0.5, 2, 2]}}]}", 0.5),
        ("solid: {union: [{box: {size: [1, 1, 1]}}, {move: {solid: {box: {size: [1, 1, 1]}}, by: [0.5, 0, 0]}}]}", 1.5),
        # The hull of two cubes of 1 whose centres are 2 apart along x.
        ("solid: {hull: [{box: {size: [1, 1, 1]}}, {move: {solid: {box: {size: [1, 1, 1]}}, by: [2, 0, 0]}}]}", 3.0),
        ("solid: {scale: {solid: {box: {size: [1, 1, 1]}}, factors: [2, 3, 0.5]}}", 3.0),
        ("solid: {row: {solid: {box: {size: [0.1, 0.1, 0.1]}}, count: 5, step: [0.2, 0, 0]}}", 0.005),
        (
            "solid: {ring: {solid: {move: {solid: {box: {size: [0.1, 0.1, 0.1]}}, by: [1, 0, 0]}}, count: 6}}",
            0.006,
        ),
        (
            "solid: {mirror: {solid: {move: {solid: {box: {size: [1, 1, 1]}}, by: [1, 0, 0]}}, normal: [2, 0, 0], "
            "copy: true}}",
            2.0,
        ),
        # A square of 1 with corners rounded by r loses (4 - pi) r^2.
        (
            FINE + "solid: {extrude: {profile: {rectangle: {size: [1, 1], corner: 0.2}}, height: 1}}",
            1.0 - (4.0 - ROUND) * 0.04,
        ),
        ("solid: {extrude: {profile: {offset: {profile: {rectangle: {size: [1, 1]}}, by: -0.1}}, height: 1}}", 0.64),
        (
            "solid: {extrude: {profile: {offset: {profile: {rectangle: {size: [1, 1]}}, by: 0.1, sharp: true}}, "
            "height: 1}}",
            1.44,
        ),
        (
            "solids: {cube: {box: {size: [1, 1, 1]}}}\nsolid: {difference: [{use: cube}, {box: {size: [0.5, 2, 2]}}]}",
            0.5,
        ),
    ],
)
def test_volumes(text: str, cubic_meters: float) -> None:
    """Geometry is in single precision on its way; a turned or rounded one has 1e-4 of its edges."""
    assert volume(made(text)) == pytest.approx(cubic_meters, rel=2e-4)


def test_a_ball_comes_near_its_formula() -> None:
    pieces = made(FINE + "solid: {sphere: {radius: 0.1}}")
    assert volume(pieces) == pytest.approx(4.0 / 3.0 * math.pi * 1e-3, rel=1e-3)
    assert area(pieces) == pytest.approx(4.0 * math.pi * 1e-2, rel=1e-3)


def test_tolerance_says_how_fine_round_things_are() -> None:
    """A chord's middle is inside its circle by r (1 - cos(pi/n))."""
    counts = []
    for tolerance in (1e-3, 1e-5):
        pieces = made(f"tolerance: {tolerance}\nsolid: {{cylinder: {{radius: 0.1, length: 0.1}}}}")
        corners = np.concatenate([piece.vertices for piece in pieces])[:, :2]
        sides = len({(round(x, 6), round(y, 6)) for x, y in corners.tolist()} - {(0.0, 0.0)})
        assert 0.1 * (1.0 - math.cos(math.pi / sides)) <= tolerance
        counts.append(sides)
    assert counts[0] < counts[1]


def test_places() -> None:
    turned = made("solid: {move: {solid: {box: {size: [0.2, 0.4, 0.6]}}, turn: [0, 0, 1.57079632679], by: [1, 0, 0]}}")
    np.testing.assert_allclose(bounds(turned), [[0.8, -0.1, -0.3], [1.2, 0.1, 0.3]], atol=1e-6)
    mirrored = made(
        "solid: {mirror: {solid: {move: {solid: {box: {size: [0.2, 0.2, 0.2]}}, by: [0.5, 0, 0]}}, normal: [1, 0, 0], "
        "point: [1, 0, 0]}}"
    )
    np.testing.assert_allclose(bounds(mirrored), [[1.4, -0.1, -0.1], [1.6, 0.1, 0.1]], atol=1e-6)
    quarter = made(
        "solid: {ring: {solid: {move: {solid: {box: {size: [0.2, 0.2, 0.2]}}, by: [1, 0, 0]}}, count: 2, "
        "angle: 1.57079632679, center: [1, 1, 0]}}"
    )
    np.testing.assert_allclose(bounds(quarter), [[0.9, -0.1, -0.1], [2.1, 1.1, 0.1]], atol=1e-6)
    upright = made("solid: {extrude: {profile: {circle: {radius: 0.1, center: [1, 0]}}, height: 0.5}}")
    np.testing.assert_allclose(bounds(upright), [[0.9, -0.1, 0.0], [1.1, 0.1, 0.5]], atol=1e-6)


def test_a_twist_turns_the_top() -> None:
    pieces = made("solid: {extrude: {profile: {rectangle: {size: [1, 0.2]}}, height: 1, twist: 1.57079632679}}")
    corners = np.concatenate([piece.vertices for piece in pieces])
    top = corners[corners[:, 2] > 1.0 - 1e-6]
    np.testing.assert_allclose(np.abs(top[:, :2]).max(axis=0), [0.1, 0.5], atol=1e-6)


def test_parts_have_colours() -> None:
    pieces = made(
        "parts:\n- {solid: {box: {size: [1, 1, 1]}}, color: orange}\n"
        "- {solid: {box: {size: [2, 2, 0.1]}}, color: [0.2, 0.4, 0.6]}\n"
    )
    assert len(pieces) == 2
    colors = [
        tuple(np.round(np.asarray(piece.color, float)[:3], 3).tolist()) for piece in pieces if piece.color is not None
    ]
    assert sorted(colors) == [(0.2, 0.4, 0.6), (1.0, 0.647, 0.0)]


def test_equal_files_are_equal_bytes() -> None:
    text = b"solid: {difference: [{sphere: {radius: 1}}, {cylinder: {radius: 0.5, length: 3}}]}"
    assert SolidImporter().translate(text, "a.solid", {}) == SolidImporter().translate(text, "a.solid", {})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected `object`, got `null`"),
        ("solid: {box: {size: [1, 1, 1]}", "no YAML"),
        ("solid: {box: {size: [1, 1, 1]}}\nparts: [{solid: {box: {size: [1, 1, 1]}}}]", "has either `solid`"),
        ("parts: []", "has either `solid`"),
        ("sold: {box: {size: [1, 1, 1]}}", "it takes solid, parts, solids, tolerance, not sold"),
        ("solid: {boks: {size: [1, 1, 1]}}", "solid: 'boks' is no word for a body; there are box, cylinder"),
        ("solid: [1, 2]", "solid: a body is one of box, cylinder"),
        ("solid: {box: {size: [1, 1, -1]}}", "solid.box.size[2]: expected `float` > 0"),
        ("solid: {box: {size: [1, 1]}}", "solid.box.size: expected `array` of length 3"),
        ("solid: {box: {}}", "solid.box: object missing required field `size`"),
        ("solid: {cylinder: {radius: 0.1, lenght: 1}}", "solid.cylinder: it takes radius, length, not lenght"),
        ("solid: {cylinder: {radius: .nan, length: 1}}", "solid.cylinder.radius: expected `float` > 0"),
        (
            "solid: {mirror: {solid: {box: {size: [1, 1, 1]}}, normal: [.nan, 0, 1]}}",
            "solid.mirror: its numbers have to be finite",
        ),
        ("solid: {cylinder: {radius: 1.0e+30, length: 1}}", "solid.cylinder.radius: expected `float` <= 1000"),
        ("solid: {cylinder: {radius: 0.1 m, length: 1}}", "solid.cylinder.radius: expected `float`, got `str`"),
        ("solid: {difference: []}", "solid.difference: expected `array` of length >= 1"),
        (
            "solid: {difference: [{box: {size: [1, 1, 1]}}, {cone: {radius: 0, length: 1}}]}",
            "solid.difference[1].cone.radius: expected `float` > 0",
        ),
        ("solid: {difference: [{box: {size: [1, 1, 1]}}, {box: {size: [2, 2, 2]}}]}", "solid: nothing is left of it"),
        ("solid: {use: wheel}\nsolids: {hub: {box: {size: [1, 1, 1]}}}", "no 'wheel' among `solids`; there are hub"),
        ("solid: {use: a}\nsolids: {a: {use: b}, b: {use: a}}", "'a' uses 'b' uses 'a', which has no end"),
        ("solid: {extrude: {profile: [[0, 0], [1, 1]], height: 1}}", "points: expected `array` of length >= 3"),
        ("solid: {extrude: {profile: [[0, 0], [1, 1], [2, 2]], height: 1}}", "the profile has no area"),
        ("solid: {lathe: {profile: [[-2, 0], [-1, 0], [-1, 1]]}}", "all of it has x below 0"),
        (
            "solid: {extrude: {profile: {rectangle: {size: [1, 2], corner: 0.6}}, height: 1}}",
            "half of the shorter side",
        ),
        (
            "solid: {mirror: {solid: {box: {size: [1, 1, 1]}}, normal: [0, 0, 0]}}",
            "solid.mirror.normal: a direction has",
        ),
        ("solid: {row: {solid: {box: {size: [1, 1, 1]}}, count: 0, step: [1, 0, 0]}}", "count: expected `int` >= 1"),
        ("parts: [{solid: {box: {size: [1, 1, 1]}}, color: orang}]", "parts[0].color: 'orang' is no colour"),
        ("parts: [{solid: {box: {size: [1, 1, 1]}}, color: [2, 0, 0]}]", "numbers of a colour are from 0 to 1"),
        ("tolerance: 0\nsolid: {sphere: {radius: 1}}", "tolerance: expected `float` >= 1e-06"),
    ],
)
def test_what_makes_no_body_is_refused_at_its_place(text: str, said: str) -> None:
    assert said in refused(text)


def test_names_that_multiply_are_refused() -> None:
    """Three rows of a hundred would be a million balls; what they come to is counted before it is made."""
    steps = {0: 30.0, 1: 0.3, 2: 0.003}
    levels = [
        f"  s{n}: {{row: {{solid: {{use: s{n + 1}}}, count: 100, step: [{step}, 0, 0]}}}}" for n, step in steps.items()
    ]
    text = "solid: {use: s0}\nsolids:\n" + "\n".join(levels) + "\n  s3: {sphere: {radius: 1.0e-3}}\n"
    assert "triangles" in refused(text)


@pytest.mark.long
def test_many_fine_bodies_are_refused() -> None:
    """A ball of a tenth of a millimeter has some 20,000 triangles; a thousand of them would take gigabytes."""
    balls = ", ".join(["{sphere: {radius: 1}}"] * 1000)
    assert "all bodies together have more than 5000000 triangles" in refused(f"solid: {{intersection: [{balls}]}}")


def test_depth_has_an_end() -> None:
    deep = "{move: {solid: " * 200 + "{sphere: {radius: 1}}" + "}}" * 200
    assert "in each other" in refused(f"solid: {deep}")


def test_aliases_that_multiply_are_refused() -> None:
    """A YAML bomb: ten anchors, each a union of ten of the one before."""
    lines = ["a0: &a0 {box: {size: [1, 1, 1]}}"]
    lines += [f"a{n}: &a{n} {{union: [{', '.join([f'*a{n - 1}'] * 10)}]}}" for n in range(1, 8)]
    text = "solids:\n" + "\n".join(f"  {line}" for line in lines) + "\nsolid: {use: a7}\n"
    assert "more than 5000 bodies" in refused(text)


def test_a_file_of_megabytes_is_refused() -> None:
    assert "at most 1048576 are read" in refused("# " + "x" * 2**20)


@pytest.mark.parametrize("number", range(40))
def test_broken_files_are_read_or_refused(number: int, rng: np.random.Generator) -> None:
    rod = b"solids: {rod: {cylinder: {radius: 0.02, length: 0.2}}}\n"
    text = rod + b"solid: {difference: [{box: {size: [0.1, 0.1, 0.1]}}, {use: rod}]}\n"
    try:
        SolidImporter().translate(broken(text, rng), "thing.solid", {})
    except ArgumentError as error:
        assert str(error).startswith("thing.solid:")


def test_the_examples_of_the_page_are_bodies() -> None:
    page = (Path(__file__).parents[4] / "docs" / "modeller.md").read_text("utf-8")
    examples = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert len(examples) == 4
    for text in examples:
        assert volume(made(text)) > 0.0
