"""Colours of visuals: those in the file, and those of Gazebo's material scripts by their names."""

from __future__ import annotations

from virtualrobot_sdk.xml import Element

from virtualrobot_plugins.importers.sdf.elements import Notes, Place, child, number, text, words
from virtualrobot_plugins.importers.xml import children

SCRIPTS: dict[str, tuple[float, float, float]] = {
    "Black": (0.0, 0.0, 0.0),
    "Blue": (0.0, 0.0, 1.0),
    "BlueLaser": (0.0, 0.0, 1.0),
    "BlueTransparent": (0.0, 0.0, 1.0),
    "DarkGray": (0.175, 0.175, 0.175),
    "DarkGrey": (0.175, 0.175, 0.175),
    "FlatBlack": (0.1, 0.1, 0.1),
    "Gold": (0.8, 0.64, 0.17),
    "Gray": (0.7, 0.7, 0.7),
    "Green": (0.0, 1.0, 0.0),
    "Grey": (0.7, 0.7, 0.7),
    "Indigo": (0.33, 0.0, 0.5),
    "Orange": (1.0, 0.5088, 0.0468),
    "Purple": (1.0, 0.0, 1.0),
    "Red": (1.0, 0.0, 0.0),
    "RedBright": (0.87, 0.26, 0.07),
    "SkyBlue": (0.13, 0.44, 0.7),
    "Turquoise": (0.0, 1.0, 1.0),
    "White": (1.0, 1.0, 1.0),
    "Yellow": (1.0, 1.0, 0.0),
    "ZincYellow": (0.97, 0.79, 0.25),
}
"""Diffuse colours of the scripts `Gazebo/...` in Gazebo classic's media/materials/scripts/gazebo.material."""

_KNOWN = {name.lower(): color for name, color in SCRIPTS.items()}


def color_of(place: Place, visual: Element, notes: Notes) -> dict[str, float] | None:
    """Return the colour of a <visual> as scene files have it; None when the file tells none."""
    material = child(visual, "material")
    shown = None if material is None else _color(place, material, notes)
    if shown is None:
        return None
    transparency = min(max(number(place, visual, "transparency", 0.0), 0.0), 1.0)
    red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in shown)
    return {"red": red, "green": green, "blue": blue, "alpha": alpha * (1.0 - transparency)}


def _color(place: Place, material: Element, notes: Notes) -> tuple[float, ...] | None:
    if any(True for _ in material.iter("{*}albedo_map")):
        notes.warn(place, material, "textures of a <material> (albedo_map) are not drawn")
    script = child(material, "script")
    name = "" if script is None else text(script, "name")
    color = _KNOWN.get(name.removeprefix("Gazebo/").lower())
    if color is not None:
        return *color, 1.0
    if name:
        notes.warn(place, material, f"the material script {name!r} is not known; known: Gazebo/{', '.join(SCRIPTS)}")
    for tag in ("diffuse", "ambient"):
        for element in children(material, tag):
            given = (element.text or "").split()
            values = words(place, element, 4 if len(given) == 4 else 3)
            return tuple(values.tolist()) if len(values) == 4 else (*values.tolist(), 1.0)
    return None
