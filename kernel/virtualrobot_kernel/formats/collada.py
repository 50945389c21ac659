"""COLLADA documents before trimesh reads them: length unit, images, and materials that would cost the shape.

Format: Khronos, COLLADA 1.4.1 and 1.5 specifications.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from copy import deepcopy
from urllib.parse import unquote

import numpy as np
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types
from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_kernel.formats.xml import FileWarning, children, malformed, parse_xml

MOST_INSTANCES = 100_000
"""Greatest number of nodes and shapes that a node comes to, those that it shows by reference written out."""

_SHAPES = ("library_geometries", "library_controllers", "library_animations", "library_visual_scenes", "library_nodes",
           "scene")  # fmt: skip


def parse_collada(data: bytes, uri: str) -> Element:
    """Return the root of a COLLADA document; a text in it may have any length, since a mesh is mostly one."""
    root = parse_xml(data, uri, huge=True)
    if local_name(root) != "COLLADA":
        raise malformed(uri, root.sourceline, f"not COLLADA: the root element is <{local_name(root)}>")
    _check_instances(root, uri)
    return root


def _check_instances(root: Element, uri: str) -> None:
    """Raise MalformedFileError when nodes that show nodes come to too many shapes, or show themselves.

    Each is written out by pycollada: ten nodes that show the next one ten times are ten billion.
    """
    places = [*root.iter("{*}node", "{*}visual_scene")]
    numbers = {place: number for number, place in enumerate(places)}
    by_id = {place.get("id"): number for number, place in enumerate(places) if place.get("id")}
    shown = [[*_shown(place, numbers, by_id)] for place in places]
    counts: dict[int, int] = {}
    under_way: set[int] = set()
    for first in range(len(places)):
        waiting = [] if first in counts else [first]
        while waiting:
            number = waiting[-1]
            under_way.add(number)
            line = line_of(places[number])
            more = [one for one in dict.fromkeys(shown[number]) if one >= 0 and one not in counts]
            if not under_way.isdisjoint(more):
                raise malformed(uri, line, "the node shows itself")
            waiting += more
            if more:
                continue
            under_way.discard(waiting.pop())
            counts[number] = 1 + sum(1 if one < 0 else counts[one] for one in shown[number])
            if counts[number] > MOST_INSTANCES:
                raise malformed(uri, line, f"the node comes to more than {MOST_INSTANCES:,} shapes, written out")


def _shown(place: Element, numbers: Mapping[Element, int], by_id: Mapping[str, int]) -> Iterator[int]:
    """Yield what a node shows: the numbers of other nodes, -1 for a shape."""
    for child in place:
        kind = local_name(child)
        if kind == "node":
            yield numbers[child]
        elif kind == "instance_node":
            yield by_id.get(child.get("url", "").removeprefix("#"), -1)
        elif kind in ("instance_geometry", "instance_controller"):
            yield -1


def length_unit(root: Element, uri: str) -> float:
    """Return the length of the file's unit in meters; 1 when it tells none (COLLADA 1.4.1, `<unit>`)."""
    unit = root.find("{*}asset/{*}unit")
    if unit is None or not unit.get("meter"):
        return 1.0
    try:
        meters = float(unit.get("meter", "1"))
    except ValueError as error:
        raise malformed(uri, unit.sourceline, f"unit meter={unit.get('meter')!r} is no number") from error
    if not np.isfinite(meters) or meters <= 0.0:
        raise malformed(uri, unit.sourceline, f"unit meter={unit.get('meter')!r} must be above 0")
    return meters


def image_names(root: Element) -> Iterator[str]:
    """Yield the names of the files with the images of a document, `%20` and the like worked out."""
    for image in root.iterfind(".//{*}library_images/{*}image"):
        for source in image.iterfind(".//{*}init_from"):
            named = source.find("{*}ref")  # COLLADA 1.5 wraps the name in <ref>
            text = (source.text if named is None else named.text) or ""
            yield unquote(text.strip()).removeprefix("./").replace("\\", "/")


def unreadable_materials(root: Element) -> list[tuple[Element, str]]:
    """Return each use of a material (`<instance_material>`) that pycollada cannot read, with its reason.

    Pycollada leaves out a shape with all its triangles when one of its materials has a broken reference in it. It is
    asked about the materials alone, in a document without shapes.
    """
    uses = [*root.iterfind(".//{*}instance_material")]
    if not uses:
        return []
    # Only now, since they take long to import.
    from collada import Collada
    from collada.common import DaeError

    small = etree.Element(root.tag, root.attrib, nsmap=root.nsmap)
    small.extend(deepcopy(part) for part in children(root, "*") if local_name(part) not in _SHAPES)
    known: set[str] = set()
    try:
        document = Collada(io.BytesIO(etree.tostring(small)), ignore=[DaeError])
        known.update(f"#{material.id}" for material in document.materials)
        said = "; ".join(dict.fromkeys(map(str, document.errors)))
    except Exception as error:  # it raises whatever a broken document makes it run into
        said = f"{type(error).__name__}: {error}"
    return [
        (use, f"the material {use.get('target', '')!r} cannot be read ({said or 'it is nowhere'})")
        for use in uses
        if use.get("target", "") not in known
    ]


def without_unreadable_materials(data: bytes, root: Element) -> bytes:
    """Return a document that has its shapes without the materials that cannot be read; `data` when there are none.

    Takes these out of the tree of `root`.
    """
    unreadable = unreadable_materials(root)
    for use, _ in unreadable:
        use.getparent().remove(use)
    return etree.tostring(root) if unreadable else data


def material_warnings(root: Element, uri: str) -> list[FileWarning]:
    """Return what is told of the materials of a document that cannot be read, each once."""
    told: dict[str, int] = {}
    for use, why in unreadable_materials(root):
        told.setdefault(why, line_of(use))
    return [FileWarning.of(malformed(uri, line, f"{why}; drawn without it")) for why, line in told.items()]
