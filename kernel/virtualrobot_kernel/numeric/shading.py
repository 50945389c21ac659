"""From what rays met to pictures: one compiled pass for what is measured, one for colours.

Light is linear: what surfaces scatter (Lambert's law) of all lights, and a little that comes from everywhere.
Source of the levels of textures: Williams, "Pyramidal Parametrics", SIGGRAPH 1983.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int32, int64, uint8
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.illumination import SKY, arriving

AMBIENT = 0.15
"""The part of white that a white surface shows without any light on it."""
HEAD_LIGHT = 0.65
"""Part of white that the camera's own light, where a scene has none, adds to a white surface that faces it; the rest
comes from everywhere then, since a light beside the eye leaves all that is seen at a slant dark."""
STEPS = 16384
"""Of linear light, in the table of what screens show."""

_OPAQUE = 0.998
_SHALLOWEST = 0.1
"""Cosine at which a pixel's footprint on a surface grows no more."""

Array = np.ndarray[Any, np.dtype[Any]]


@compiled(
    *(array_of(float64, 2), array_of(float32, 2), array_of(int32, 1), float64, float64, boolean),
    *(array_of(float32, 1), array_of(int32, 1), array_of(float32, 2), array_of(int32, 1)),
    *(output_of(float32, 1), output_of(int32, 1), output_of(float32, 2)),
)
def measure(
    world_t_camera: Array,
    directions: Array,
    pixels: Array,
    near: float,
    far: float,
    along_z: bool,
    distance: Array,
    element: Array,
    normal: Array,
    places: Array,
    depth: Array,
    segmentation: Array,
    normals: Array,
) -> None:
    """Write depth, segmentation and normals of a picture of n pixels; an empty result is left out.

    Args:
        world_t_camera: (4, 4)
        directions: (n, 3) of the rays in the camera's frame.
        pixels: (n,) the pixel of each ray.
        near: where the rays began.
        far: what is farther is not seen.
        along_z: whether depth is measured along z or along the ray.
        distance: (n,) that the rays went, inf where they met nothing.
        element: (n,) what they met.
        normal: (n, 3) unit normals in the world, turned to either side.
        places: (e,) what segmentation says of each element.
        depth: (n,) or (0,) result, by pixel.
        segmentation: (n,) or (0,) result; -1 where there is nothing.
        normals: (n, 3) or (0, 3) result, in the camera's frame, turned to the camera; 0 where there is nothing.
    """
    for i in range(len(directions)):
        pixel = pixels[i]
        value = near + distance[i] * (directions[i, 2] if along_z else 1.0)
        is_seen = element[i] >= 0 and value <= far
        if len(depth):
            depth[pixel] = value if is_seen else np.inf
        if len(segmentation):
            segmentation[pixel] = places[element[i]] if is_seen else -1
        if len(normals):
            facing = 0.0
            for axis in range(3):
                turned = 0.0
                if is_seen:
                    for row in range(3):
                        turned += world_t_camera[row, axis] * normal[i, row]
                normals[pixel, axis] = turned
                facing += turned * directions[i, axis]
            if facing > 0.0:
                for axis in range(3):
                    normals[pixel, axis] = -normals[pixel, axis]


@inlined
def _sample(
    texels: Array, first: int, width: int, height: int, u: float, v: float, light: Array
) -> tuple[float, float, float, float]:
    """Return the light and opacity of a repeated texture at (u, v) from the lower left, between its pixels."""
    x = (u - math.floor(u)) * width - 0.5
    y = (1.0 - (v - math.floor(v))) * height - 0.5
    left, top = math.floor(x), math.floor(y)
    a, b = x - left, y - top
    # Divisions would take longer than all else: what is no number, too, is in the texture so.
    column, row = int(left) if left >= 0.0 else width - 1, int(top) if top >= 0.0 else height - 1
    after, below = column + 1 if column + 1 < width else 0, row + 1 if row + 1 < height else 0
    red, green, blue, opacity = 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        place = first + (below if k >= 2 else row) * width + (after if k % 2 else column)
        weight = (b if k >= 2 else 1.0 - b) * (a if k % 2 else 1.0 - a)
        red += weight * light[int(texels[place, 0])]
        green += weight * light[int(texels[place, 1])]
        blue += weight * light[int(texels[place, 2])]
        opacity += weight * texels[place, 3]
    return red, green, blue, opacity / 255.0


@inlined
def _texture(
    textures: Array, levels: Array, texels: Array, texture: int, u: float, v: float, level: float, light: Array
) -> tuple[float, float, float, float]:
    """Return the light and opacity of a texture at (u, v), between two of its levels."""
    first, count = textures[texture, 0], textures[texture, 1]
    level = min(max(level, 0.0), count - 1.0)
    low = int(level)
    at = first + low
    red, green, blue, opacity = _sample(texels, levels[at, 0], levels[at, 1], levels[at, 2], u, v, light)
    part = level - low
    if part > 0.0:
        at += 1
        a, b, c, d = _sample(texels, levels[at, 0], levels[at, 1], levels[at, 2], u, v, light)
        red, green, blue = red + part * (a - red), green + part * (b - green), blue + part * (c - blue)
        opacity += part * (d - opacity)
    return red, green, blue, opacity


@inlined
def _blend(
    colors: Array, first: int, second: int, third: int, u: float, v: float, w: float, light: Array
) -> tuple[float, float, float, float]:
    """Return the light and opacity between three corners of weights u, v, w."""
    red = u * light[int(colors[first, 0])] + v * light[int(colors[second, 0])] + w * light[int(colors[third, 0])]
    green = u * light[int(colors[first, 1])] + v * light[int(colors[second, 1])] + w * light[int(colors[third, 1])]
    blue = u * light[int(colors[first, 2])] + v * light[int(colors[second, 2])] + w * light[int(colors[third, 2])]
    opacity = u * colors[first, 3] + v * colors[second, 3] + w * colors[third, 3]
    return red, green, blue, opacity / 255.0


@inlined
def _step(light: float) -> int:
    """Return the place of linear light in the table of what screens show; what is no number is white."""
    if not light < 1.0:
        return STEPS - 1
    return int(light * (STEPS - 1) + 0.5) if light > 0.0 else 0


@compiled(
    # rays
    *(array_of(float32, 2), array_of(float32, 2), array_of(int32, 1), array_of(float32, 2), array_of(float32, 1)),
    *(float64, float64, float64),
    # what they met
    *(array_of(float32, 1), array_of(int32, 1), array_of(int32, 1), array_of(float32, 2), array_of(float32, 2)),
    # looks
    *(array_of(float64, 3), array_of(float32, 2), array_of(int64, 2), array_of(int32, 2), array_of(int32, 1)),
    *(array_of(float32, 1), array_of(float32, 2), array_of(uint8, 2), array_of(float32, 2), array_of(float32, 2)),
    *(array_of(int32, 2), array_of(int64, 2), array_of(int64, 2), array_of(uint8, 2)),
    # light
    *(array_of(float32, 2), array_of(boolean, 2), array_of(float32, 1), array_of(float32, 1), array_of(uint8, 1)),
    # results
    *(boolean, output_of(uint8, 2), output_of(int32, 1), output_of(float32, 2)),
)
def shade(
    origins: Array,
    directions: Array,
    pixels: Array,
    carried: Array,
    slant: Array,
    near: float,
    far: float,
    pixel_angle: float,
    distance: Array,
    element: Array,
    triangle: Array,
    uv: Array,
    normal: Array,
    poses: Array,
    colors: Array,
    element_starts: Array,
    faces: Array,
    part_of: Array,
    texel: Array,
    smooth: Array,
    corner_colors: Array,
    corner_uv: Array,
    part_colors: Array,
    part_looks: Array,
    textures: Array,
    levels: Array,
    texels: Array,
    lights: Array,
    shadowed: Array,
    background: Array,
    to_light: Array,
    to_screen: Array,
    is_last: bool,
    picture: Array,
    onward: Array,
    passed: Array,
) -> int:
    """Write the colours of what n rays met to a picture; return how many rays go on behind something translucent.

    Args:
        origins: (n, 3) in meters in the world.
        directions: (n, 3) unit vectors in the world; one of NaN is a pixel that looks nowhere, and black.
        pixels: (n,) where in the picture each is seen.
        carried: (n, 5) red, green, blue that a ray has gathered, the part of what is behind that shows, how far it has
            gone already; (0, 5) for rays that have just begun.
        slant: (n,) what the way of each ray is multiplied by to be measured as `near` and `far` are.
        near: where rays began.
        far: what is farther is not seen.
        pixel_angle: between neighbours, in radians.
        distance: (n,) as in `Traced`, so also the next four.
        element: (n,)
        triangle: (n,)
        uv: (n, 2)
        normal: (n, 3)
        poses: (e, 4, 4) world_t_element.
        colors: (e, 4) as in `Appearances`, so also the next.
        element_starts: (e, 4)
        faces: as in `Surfaces`, so also all up to `texels`.
        part_of: (f,)
        texel: (f,)
        smooth: (v, 3)
        corner_colors: (v, 4) or (0, 4)
        corner_uv: (v, 2) or (0, 2)
        part_colors: (p, 4)
        part_looks: (p, 2)
        textures: (t, 2)
        levels: (l, 3)
        texels: (x, 4)
        lights: (k, LIGHT_FIELDS); where there is none, one at the eye lights all, at any distance alike.
        shadowed: (k, n) where something is in a light's way.
        background: (3,) linear light.
        to_light: (256,) linear light of what screens show.
        to_screen: (STEPS,) what screens show of linear light.
        is_last: whether rays end here, whatever they meet.
        picture: (m, 3) result.
        onward: (n,) result: the rays that go on.
        passed: (n, 5) result: what these carry.
    """
    going = 0
    begun = len(carried) > 0
    for i in range(len(directions)):
        red = green = blue = gone = 0.0
        share = 1.0
        if begun:
            red, green, blue = float64(carried[i, 0]), float64(carried[i, 1]), float64(carried[i, 2])
            share, gone = float64(carried[i, 3]), float64(carried[i, 4])
        pixel = pixels[i]
        e: int = element[i]
        if e < 0 or near + (gone + distance[i]) * slant[i] > far:
            if directions[i, 0] == directions[i, 0]:
                red += share * background[0]
                green += share * background[1]
                blue += share * background[2]
        else:
            dx, dy, dz = float64(directions[i, 0]), float64(directions[i, 1]), float64(directions[i, 2])
            gx, gy, gz = float64(normal[i, 0]), float64(normal[i, 1]), float64(normal[i, 2])
            facing = -(dx * gx + dy * gy + dz * gz)
            if facing < 0.0:
                gx, gy, gz, facing = -gx, -gy, -gz, -facing
            nx, ny, nz = gx, gy, gz
            r, g, b, opacity = (
                float64(colors[e, 0]),
                float64(colors[e, 1]),
                float64(colors[e, 2]),
                float64(colors[e, 3]),
            )
            if element_starts[e, 0] >= 0 and triangle[i] >= 0:
                face = element_starts[e, 0] + triangle[i]
                first = element_starts[e, 1] + faces[face, 0]
                second = element_starts[e, 1] + faces[face, 1]
                third = element_starts[e, 1] + faces[face, 2]
                v, w = float64(uv[i, 0]), float64(uv[i, 1])
                u = 1.0 - v - w
                sx = u * smooth[first, 0] + v * smooth[second, 0] + w * smooth[third, 0]
                sy = u * smooth[first, 1] + v * smooth[second, 1] + w * smooth[third, 1]
                sz = u * smooth[first, 2] + v * smooth[second, 2] + w * smooth[third, 2]
                nx = poses[e, 0, 0] * sx + poses[e, 0, 1] * sy + poses[e, 0, 2] * sz
                ny = poses[e, 1, 0] * sx + poses[e, 1, 1] * sy + poses[e, 1, 2] * sz
                nz = poses[e, 2, 0] * sx + poses[e, 2, 1] * sy + poses[e, 2, 2] * sz
                length = math.sqrt(nx * nx + ny * ny + nz * nz)
                if length > 1e-6:
                    if nx * gx + ny * gy + nz * gz < 0.0:
                        length = -length
                    nx, ny, nz = nx / length, ny / length, nz / length
                else:
                    nx, ny, nz = gx, gy, gz
                part = element_starts[e, 2] + part_of[face]
                if element_starts[e, 3] == 0:
                    r, g, b = part_colors[part, 0], part_colors[part, 1], part_colors[part, 2]
                    opacity = part_colors[part, 3]
                if part_looks[part, 0] >= 0:
                    a = u * corner_uv[first, 0] + v * corner_uv[second, 0] + w * corner_uv[third, 0]
                    c = u * corner_uv[first, 1] + v * corner_uv[second, 1] + w * corner_uv[third, 1]
                    wide = pixel_angle * (gone + distance[i]) / math.sqrt(max(facing, _SHALLOWEST))
                    level = math.log2(max(wide / texel[face], 1.0)) if texel[face] > 0.0 else 0.0
                    tr, tg, tb, to = _texture(textures, levels, texels, part_looks[part, 0], a, c, level, to_light)
                    r, g, b, opacity = r * tr, g * tg, b * tb, opacity * to
                elif element_starts[e, 3] == 0 and part_looks[part, 1] == 1:
                    r, g, b, opacity = _blend(corner_colors, first, second, third, u, v, w, to_light)
            lr = lg = lb = AMBIENT
            if len(lights) == 0:
                lr = lg = lb = 1.0 - HEAD_LIGHT + HEAD_LIGHT * max(-(dx * nx + dy * ny + dz * nz), 0.0)
            else:
                x = origins[i, 0] + dx * distance[i]
                y = origins[i, 1] + dy * distance[i]
                z = origins[i, 2] + dz * distance[i]
                for k in range(len(lights)):
                    if shadowed[k, i]:
                        continue
                    a, c, d, _, strength = arriving(lights, k, x, y, z)
                    lit = 0.0
                    if lights[k, 0] == SKY:
                        lit = 0.5 + 0.5 * (a * nx + c * ny + d * nz)
                    elif strength > 0.0 and a * gx + c * gy + d * gz > 0.0:
                        lit = strength * max(a * nx + c * ny + d * nz, 0.0)
                    if lit > 0.0:
                        lr, lg, lb = lr + lit * lights[k, 7], lg + lit * lights[k, 8], lb + lit * lights[k, 9]
            red += share * opacity * r * lr
            green += share * opacity * g * lg
            blue += share * opacity * b * lb
            share *= 1.0 - opacity
            if opacity < _OPAQUE:
                if not is_last:
                    onward[going] = i
                    passed[going, 0], passed[going, 1], passed[going, 2] = red, green, blue
                    passed[going, 3], passed[going, 4] = share, gone + distance[i]
                    going += 1
                    continue
                red += share * background[0]
                green += share * background[1]
                blue += share * background[2]
        picture[pixel, 0] = to_screen[_step(red)]
        picture[pixel, 1] = to_screen[_step(green)]
        picture[pixel, 2] = to_screen[_step(blue)]
    return going
