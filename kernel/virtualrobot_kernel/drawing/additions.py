"""Additions that people see and sensors do not: arrows among solid things; lines, points and words over them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.rays import Shape

from virtualrobot_kernel.collision.clearances import Measured
from virtualrobot_kernel.drawing.alarm import Touching, contact_points
from virtualrobot_kernel.drawing.extent import node_box
from virtualrobot_kernel.drawing.ghosts import ghost_figures
from virtualrobot_kernel.drawing.inventory import figures_of, joint_axes
from virtualrobot_kernel.drawing.library import AXIS_ARROW
from virtualrobot_kernel.drawing.library import ShapeLibrary as DrawnShapes
from virtualrobot_kernel.drawing.overlay import Overlay, Words
from virtualrobot_kernel.drawing.palette import (
    BOX_COLOR,
    BOX_WIDTH,
    CLEARANCE_COLOR,
    CONTACT_COLOR,
    CONTACT_SIZE,
    MEASURE_COLOR,
    MEASURE_WIDTH,
    box_edges,
    clearance_words,
    ink,
    measured_words,
)
from virtualrobot_kernel.drawing.sensor_strokes import add_sensors
from virtualrobot_kernel.drawing.view import ViewSettings
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.sensing.measuring import ends, is_there
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.shapes import primitives, submesh
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.figures import Figure, Frame, Label, Lines, Material, Mesh, Points
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import FOR_PEOPLE
from virtualrobot_kernel.world.visibility import inherited_visibility

FRAME = "virtualrobot:frame"
AXIS = "virtualrobot:axis"
ARROWS = {FRAME: primitives.frame, AXIS: primitives.axis_arrow}
"""Meshes that no file holds, by their addresses."""


def with_arrows(meshes: Meshes) -> Meshes:
    """Return what gives the triangles of arrows too, and asks `meshes` for all others."""

    def load(mesh: Mesh) -> tuple[submesh.Submesh, ...]:
        made = ARROWS.get(mesh.uri)
        return (submesh.transformed(made(), np.diag(mesh.scale)),) if made else meshes(mesh)

    return load


def shown_figures(snapshot: Snapshot) -> Iterator[tuple[int, Figure]]:
    """Yield what people see and sensors do not (uid, figure): figures of annotations, frames, lines and such."""
    structure = snapshot.structure
    hidden, states = inherited_visibility(structure, snapshot.state.tool_states)
    for uid, node in structure.nodes.items():
        if hidden[uid]:
            continue
        for figure in figures_of(node):
            is_drawn = node.kind in FOR_PEOPLE or isinstance(figure.geometry, Points | Lines | Frame | Label)
            if is_drawn and figure.visual and figure.tool_state in ("", states[uid]):
                yield uid, figure


def with_drawn(
    elements: Elements, snapshot: Snapshot, settings: ViewSettings, arrows: ShapeLibrary, drawn: DrawnShapes
) -> Elements:
    """Return the elements with the solid ones of annotations, with the arrows of frames and of joint axes, with ghosts.

    Args:
        elements: what sensors see.
        snapshot: the world.
        settings: says of which robots the joint axes are shown, and which ghosts.
        arrows: makes the shapes of what is added; it knows arrows.
        drawn: says how large links are, which the length of their axes goes by.
    """
    structure = snapshot.structure
    added: list[tuple[int, Figure]] = []
    for uid, figure in shown_figures(snapshot):
        if isinstance(figure.geometry, Frame):
            length = figure.geometry.length
            added.append((uid, replace(figure, geometry=Mesh(FRAME, "", (length, length, length)), material=None)))
        else:
            added.append((uid, figure))
    for uid, piece in joint_axes(structure, settings.joint_axes, drawn):
        assert piece.key[0] == AXIS_ARROW
        added.append((uid, Figure(Mesh(AXIS, "", piece.scale), piece.node_t_shape, Material(piece.key[1]))))
    added.extend(ghost_figures(snapshot, settings.ghosts))
    solid: list[tuple[int, Figure, Shape]] = [
        (uid, figure, shape) for uid, figure in added if (shape := arrows.get(figure.geometry)) is not None
    ]
    return elements.with_figures(solid)


def overlay_of(
    snapshot: Snapshot,
    settings: ViewSettings,
    elements: Elements,
    readings: Mapping[int, Reading],
    touching: Touching,
    clearances: Measured,
) -> Overlay:
    """Return the lines, points and words of annotations, bounding boxes, distances, sensors and contacts."""
    overlay = Overlay()
    for uid, figure in shown_figures(snapshot):
        _annotate(overlay, snapshot.world_t(uid) @ figure.node_t_figure, figure)
    for uid in settings.bounding_boxes:
        box = node_box(elements, snapshot, uid)
        if box is not None:
            overlay.add_lines(moved(snapshot.world_t(uid), box_edges(box)), BOX_COLOR, BOX_WIDTH)
    add_sensors(overlay, snapshot, settings.sensors, readings)
    if touching:
        overlay.add_dots(contact_points(touching), CONTACT_COLOR, CONTACT_SIZE)
    for measurement in settings.measurements:
        if is_there(snapshot, measurement):
            points = ends(snapshot, measurement.first, measurement.second)
            overlay.add_lines(points[None], MEASURE_COLOR, MEASURE_WIDTH)
            text = measured_words(measurement, points)
            overlay.words.append(Words(text, points.mean(axis=0), MEASURE_COLOR))
    for clearance, nearest in clearances.items():
        overlay.add_lines(nearest.points[None], CLEARANCE_COLOR, MEASURE_WIDTH)
        text = clearance_words(clearance, nearest)
        overlay.words.append(Words(text, nearest.points.mean(axis=0), CLEARANCE_COLOR))
    return overlay


def moved(pose: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (..., 3) under a pose (4, 4)."""
    return points @ pose[:3, :3].T + pose[:3, 3]


def _annotate(overlay: Overlay, pose: NDArray[np.float64], figure: Figure) -> None:
    match figure.geometry:
        case Points(positions, colors, size) if positions:
            own = np.frombuffer(colors, np.uint8).reshape(-1, 3) if colors else ink(figure)
            overlay.add_dots(moved(pose, np.frombuffer(positions, np.float64).reshape(-1, 3)), own, size)
        case Lines(segments, width) if segments:
            overlay.add_lines(moved(pose, np.frombuffer(segments, np.float64).reshape(-1, 2, 3)), ink(figure), width)
        case Label(text) if text:
            overlay.words.append(Words(text, pose[:3, 3]))
