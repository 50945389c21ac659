"""Colours of pictures against the formulas of light: Lambert, inverse square, cones, shadows, layers, textures."""

from __future__ import annotations

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from virtualrobot_kernel.numeric.shading import AMBIENT, HEAD_LIGHT
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.sensing.lenses import Lens, lens_of
from virtualrobot_kernel.sensing.lights import FADING, NONE, Lights
from virtualrobot_kernel.sensing.picture import render
from virtualrobot_kernel.sensing.textures import levels
from virtualrobot_kernel.shapes.shape_library import EMPTY, ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Figure, Mesh, Sphere
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Light, LightKind
from virtualrobot_sdk.srgb import from_linear, to_linear

from tests.unit.sensing.studio import Thing, at, lit_by, looking, studio

DOWN = at(0, 0, 0, turn=np.diag([1.0, -1.0, -1.0]))
"""Looks down, x to the right."""
FLOOR: Thing = (Box((40, 40, 1)), at(0, 0, -0.5), (0.8, 0.5, 0.3, 1.0))
ALBEDO = to_linear([0.8, 0.5, 0.3])
LENS = lens_of(CameraSensor(80, 60, horizontal_field_radians=1.2))
SCREEN_STEP = 1.01
"""Colours are whole numbers."""


def above(height: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    pose = DOWN.copy()
    pose[:3, 3] = x, y, height
    return pose


def shot(
    things: list[Thing],
    camera: np.ndarray,
    lights: Lights = NONE,
    lens: Lens = LENS,
    meshes: dict[str, tuple[Submesh, ...]] | None = None,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> np.ndarray:
    with studio(things, lights, meshes, background) as (scene, subject):
        picture = render(scene, subject, lens, camera, [ImageKind.COLOR])
    assert picture.color is not None
    return picture.color.astype(float)


def floor_points(camera: np.ndarray, lens: Lens = LENS) -> np.ndarray:
    """Where the pixels' rays meet the plane z = 0, (h, w, 3)."""
    rays = np.empty((lens.width * lens.height, 3))
    rays[lens.pixels] = lens.directions @ camera[:3, :3].T
    points = camera[:3, 3] - rays * (camera[2, 3] / rays[:, 2:])
    return points.reshape(lens.height, lens.width, 3)


def shown(light: np.ndarray) -> np.ndarray:
    return 255.0 * from_linear(light)


def test_without_lights_the_camera_has_its_own() -> None:
    camera = looking([0, -2, 2], [0, 0, 0])
    rays = floor_points(camera) - camera[:3, 3]
    cosine = -rays[..., 2:] / np.linalg.norm(rays, axis=2, keepdims=True)
    expected = shown(ALBEDO * (1.0 - HEAD_LIGHT + HEAD_LIGHT * cosine))
    np.testing.assert_allclose(shot([FLOOR], camera), expected, atol=SCREEN_STEP)


def test_white_that_faces_a_light_of_1_at_1_m_is_white() -> None:
    white: Thing = (Box((9, 9, 1)), at(0, 0, -0.5), (1.0, 1.0, 1.0, 1.0))
    for kind in LightKind:
        seen = shot([white], above(3.0), lit_by((Light(kind), above(1.0))))
        assert (seen[29:31, 39:41] == 255).all()


def test_a_point_light_follows_lambert_and_the_inverse_square(rng: np.random.Generator) -> None:
    place = rng.uniform([-2, -2, 1], [2, 2, 3])
    color, intensity = rng.uniform(0.3, 1.0, 3), rng.uniform(0.5, 2.0)
    light = Light(LightKind.POINT, (*color, 1.0), intensity)
    to_light = place - floor_points(above(4.0))
    distance = np.linalg.norm(to_light, axis=2, keepdims=True)
    irradiance = intensity * to_linear(color) * (to_light[..., 2:] / distance) / distance**2
    expected = shown(ALBEDO * (AMBIENT + irradiance))
    np.testing.assert_allclose(shot([FLOOR], above(4.0), lit_by((light, at(*place)))), expected, atol=SCREEN_STEP)


def test_lights_add_up_and_directional_ones_know_no_distance(rng: np.random.Generator) -> None:
    first = looking([0, 0, 0], rng.uniform([-1, -1, -2], [1, 1, -1]))
    second = looking([0, 0, 50], rng.uniform([-30, -30, 0], [30, 30, 5]))
    sun = Light(LightKind.DIRECTIONAL, intensity=0.3)
    seen = shot([FLOOR], above(4.0), lit_by((sun, first), (sun, second)))
    lit = 0.3 * (-first[2, 2] - second[2, 2])
    np.testing.assert_allclose(seen, np.broadcast_to(shown(ALBEDO * (AMBIENT + lit)), seen.shape), atol=SCREEN_STEP)


def test_a_spot_ends_at_its_cone_and_is_full_within() -> None:
    angle, height = 0.4, 2.0
    spot = Light(LightKind.SPOT, intensity=4.0, cone_angle_radians=angle)
    seen = shot([FLOOR], above(4.0), lit_by((spot, above(height))))
    points = floor_points(above(4.0))
    radius = np.hypot(points[..., 0], points[..., 1])
    dark = radius > height * math.tan(angle) + 1e-3
    full = radius < height * math.tan(FADING * angle) - 1e-3
    np.testing.assert_allclose(seen[dark], np.broadcast_to(shown(ALBEDO * AMBIENT), seen[dark].shape), atol=1)
    distance = np.hypot(radius, height)[..., None]
    expected = shown(ALBEDO * (AMBIENT + 4.0 * (height / distance) / distance**2))
    np.testing.assert_allclose(seen[full], expected[full], atol=SCREEN_STEP)
    between = ~dark & ~full
    assert between.any()
    assert (seen[between] <= expected[between] + 1).all()


def test_a_shadow_is_where_the_geometry_says() -> None:
    ball: Thing = (Sphere(0.25), at(0, 0, 1.0), None)
    light = Light(LightKind.POINT, intensity=4.0)
    camera = above(6.0, x=1.0)
    with_shadow = shot([FLOOR, ball], camera, lit_by((light, at(0, 0, 2.0))))
    without = shot(
        [FLOOR, ball], camera, lit_by((Light(LightKind.POINT, intensity=4.0, shadowless=True), at(0, 0, 2.0)))
    )
    points = floor_points(camera)
    radius = np.hypot(points[..., 0], points[..., 1])
    # The cone that touches the ball has the sine 0.25 / 1.
    edge = 2.0 * math.tan(math.asin(0.25))
    seen_floor = np.hypot(points[..., 0] + 0.2, points[..., 1]) > 0.4  # the ball is before the floor at x = -0.2
    inside, outside = (radius < edge - 1e-2) & seen_floor, (radius > edge + 1e-2) & seen_floor
    assert inside.any()
    dark = np.broadcast_to(shown(ALBEDO * AMBIENT), with_shadow[inside].shape)
    np.testing.assert_allclose(with_shadow[inside], dark, atol=SCREEN_STEP)
    np.testing.assert_allclose(with_shadow[outside], without[outside], atol=0)
    assert (without[inside] > dark + 10).all()


def test_translucent_things_let_through_what_is_behind() -> None:
    panes: list[Thing] = [
        (Box((9, 9, 0.01)), at(0, 0, 2.0), (1.0, 0.2, 0.2, 0.25)),
        (Box((9, 9, 0.01)), at(0, 0, 1.0), (0.2, 0.2, 1.0, 0.5)),
    ]
    seen = shot([FLOOR, *panes], above(3.0))[30, 40]
    # Each pane has a front and a back; what faces the camera is fully lit by its light.
    light, share = np.zeros(3), 1.0
    for color, opacity in (((1.0, 0.2, 0.2), 0.25),) * 2 + (((0.2, 0.2, 1.0), 0.5),) * 2:
        light += share * opacity * to_linear(color)
        share *= 1.0 - opacity
    np.testing.assert_allclose(seen, shown(light + share * ALBEDO), atol=1.5)
    over_nothing = shot(panes[:1], above(3.0), background=(0.9, 0.9, 0.9))[30, 40]
    light = (1.0 - 0.75**2) * to_linear([1.0, 0.2, 0.2]) + 0.75**2 * to_linear([0.9] * 3)
    np.testing.assert_allclose(over_nothing, shown(light), atol=1.5)


def checker(cells: int, pixels: int) -> bytes:
    row, column = np.indices((cells * pixels, cells * pixels)) // pixels
    colors = np.array([[220, 40, 30], [30, 60, 200]], np.uint8)[(row + column) % 2]
    packed = io.BytesIO()
    Image.fromarray(colors).save(packed, "PNG")
    return packed.getvalue()


def square(**looks: object) -> Submesh:
    """A square of 2 m at z = 0; uv (0, 0) at its lower left corner as seen from above."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    return Submesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32), **looks)  # type: ignore[arg-type]


MESH = Mesh("square.obj", "square")
CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)


def at_place(picture: np.ndarray, camera: np.ndarray, x: float, y: float) -> np.ndarray:
    points = floor_points(camera)
    nearest = np.argmin(np.hypot(points[..., 0] - x, points[..., 1] - y))
    return picture.reshape(-1, 3)[nearest]


def test_a_texture_lies_where_its_coordinates_say() -> None:
    camera, cells = above(2.2), 4
    part = square(uv=CORNERS, texture=checker(cells, 32))
    seen = shot([(MESH, np.eye(4), None)], camera, meshes={"square": (part,)})
    for row in range(cells):
        for column in range(cells):
            # The upper left cell of the picture is at x = -1, y = 1.
            x, y = (column + 0.5) / cells * 2 - 1, 1 - (row + 0.5) / cells * 2
            points = np.array([x, y, -camera[2, 3]])
            cosine = -points[2] / np.linalg.norm(points)
            color = [[220, 40, 30], [30, 60, 200]][(row + column) % 2]
            light = to_linear(np.array(color) / 255.0) * (1.0 - HEAD_LIGHT + HEAD_LIGHT * cosine)
            np.testing.assert_allclose(at_place(seen, camera, x, y), shown(light), atol=4)


def test_a_materials_colour_is_a_factor_on_textures_and_in_place_of_other_colours() -> None:
    camera, tint = above(2.2), (0.5, 0.9, 0.4, 1.0)
    textured = square(uv=CORNERS, texture=checker(1, 8))
    seen = shot([(MESH, np.eye(4), tint)], camera, meshes={"square": (textured,)})[30, 40]
    np.testing.assert_allclose(seen, shown(to_linear(np.array([220, 40, 30]) / 255.0) * to_linear(tint[:3])), atol=1.5)
    colored = square(vertex_colors=np.full((4, 4), 255, np.uint8), color=(1.0, 0.0, 0.0, 1.0))
    seen = shot([(MESH, np.eye(4), tint)], camera, meshes={"square": (colored,)})[30, 40]
    np.testing.assert_allclose(seen, 255.0 * np.array(tint[:3]), atol=1.5)


def test_vertex_colours_are_blended_as_light() -> None:
    camera = above(2.2)
    colors = np.array([[255, 0, 0, 255], [255, 0, 0, 255], [0, 0, 255, 255], [0, 0, 255, 255]], np.uint8)
    seen = shot([(MESH, np.eye(4), None)], camera, meshes={"square": (square(vertex_colors=colors),)})
    for y in (-0.8, -0.3, 0.0, 0.4, 0.8):
        point = np.array([0.0, y, -camera[2, 3]])
        lit = 1.0 - HEAD_LIGHT + HEAD_LIGHT * camera[2, 3] / np.linalg.norm(point)
        part = (y + 1.0) / 2.0
        # A pixel is 4 cm: 0.02 of the light between.
        expected = np.array([(1.0 - part) * lit, 0.0, part * lit])
        np.testing.assert_allclose(to_linear(at_place(seen, camera, 0.0, y) / 255.0), expected, atol=0.03)


def test_parts_of_a_mesh_have_their_own_colours() -> None:
    left = square(color=(1.0, 0.0, 0.0, 1.0))
    right = Submesh(left.vertices + np.array([2, 0, 0], np.float32), left.faces, color=(0.0, 1.0, 0.0, 1.0))
    none = Submesh(left.vertices - np.array([2, 0, 0], np.float32), left.faces)
    camera = above(6.0)
    seen = shot([(MESH, np.eye(4), None)], camera, meshes={"square": (left, right, none)})
    assert at_place(seen, camera, 0, 0).argmax() == 0
    assert at_place(seen, camera, 2, 0).argmax() == 1
    assert np.ptp(at_place(seen, camera, -2, 0)) < 20  # grey


def test_a_texture_far_away_is_its_mean_light() -> None:
    # Cells of 4 mm seen from 60 m: hundreds in each pixel, which would show either at random.
    part = square(uv=CORNERS, texture=checker(512, 2))
    seen = shot([(MESH, np.eye(4), None)], above(60.0), meshes={"square": (part,)})
    mean = 0.5 * (to_linear(np.array([220, 40, 30]) / 255.0) + to_linear(np.array([30, 60, 200]) / 255.0))
    np.testing.assert_allclose(seen[29:31, 39:41].reshape(-1, 3), np.tile(shown(mean), (4, 1)), atol=3)


def test_a_mesh_with_smooth_normals_is_shaded_like_the_sphere_that_it_stands_for() -> None:
    from virtualrobot_kernel.shapes import primitives

    camera = looking([0, -3, 0], [0, 0, 0])
    light = lit_by((Light(LightKind.DIRECTIONAL, intensity=0.8, shadowless=True), looking([0, 0, 0], [1, 1, -1])))
    color = (0.7, 0.7, 0.7, 1.0)
    exact = shot([(Sphere(1.0), np.eye(4), color)], camera, light)
    mesh = shot([(Mesh("ball.stl", "ball"), np.eye(4), color)], camera, light, meshes={"ball": (primitives.sphere(),)})
    row, column = np.indices((60, 80))
    inner = np.hypot(row - 29.5, column - 39.5) < 17
    # 48 x 24 facets: flat ones would be wrong by up to 15; where the light only grazes them they are dark too soon.
    assert np.percentile(np.abs(exact - mesh)[inner], 95) < 3


@pytest.mark.parametrize("texture", [b"no picture", b""])
def test_a_texture_that_is_no_picture_is_left_out(texture: bytes) -> None:
    part = square(uv=CORNERS, texture=texture, color=(0.0, 1.0, 0.0, 1.0))
    seen = shot([(MESH, np.eye(4), None)], above(2.2), meshes={"square": (part,)})[30, 40]
    assert seen.argmax() == 1


def test_levels_of_a_texture_are_means_of_light(rng: np.random.Generator) -> None:
    pixels = rng.integers(0, 256, (13, 6, 4), np.uint8)
    packed = io.BytesIO()
    Image.fromarray(pixels, "RGBA").save(packed, "PNG")
    found = levels(packed.getvalue())
    assert [level.shape for level in found] == [(13, 6, 4), (6, 3, 4), (3, 1, 4), (1, 1, 4)]
    np.testing.assert_array_equal(found[0], pixels)
    light = to_linear(pixels[:12, :, :3] / 255.0).reshape(6, 2, 3, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(found[1][..., :3], shown(light), atol=1)
    np.testing.assert_allclose(found[1][..., 3], pixels[:12, :, 3].reshape(6, 2, 3, 2).mean(axis=(1, 3)), atol=0.51)


def test_the_brightest_light_is_white_and_no_more() -> None:
    for distance in (1e-3, 3.0):
        light = lit_by((Light(LightKind.POINT, intensity=1e9), at(0, 0, distance)))
        assert (shot([FLOOR], above(2.0), light)[29:31, 39:41] == 255).all()


def test_a_mesh_that_is_read_otherwise_the_second_time_has_no_look() -> None:
    whole = square(color=(0.0, 1.0, 0.0, 1.0))
    short = replace(whole, faces=whole.faces[:1])
    with studio([(MESH, np.eye(4), None)], meshes={"square": (whole,)}) as (scene, subject):
        elements = Elements(
            (ShapeLibrary(lambda mesh: (whole,)).get(MESH) or EMPTY,),
            (Figure(MESH),),
            np.arange(1),
            np.arange(1),
            np.eye(4)[None],
            np.ones(1),
            made_of=None,  # type: ignore[arg-type]  there is no world
        )
        subject = replace(subject, looks=AppearanceLibrary(lambda mesh: (short,)).of(elements))
        color = render(scene, subject, LENS, above(2.2), [ImageKind.COLOR]).color
    assert color is not None
    assert np.ptp(color[30, 40].astype(int)) < 20  # grey
