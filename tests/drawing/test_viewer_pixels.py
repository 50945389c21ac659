"""What people see: pixels of the viewer's page in a real browser."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from virtualrobot_kernel.drawing.view import Camera
from virtualrobot_kernel.sensing.measuring import Measurement, NodePoint
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import RemoveNode, SetJointPositions, SetToolState, UpdateNode
from virtualrobot_kernel.world.figures import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Geometry,
    Label,
    Lines,
    Material,
    Mesh,
    Points,
    Sphere,
)
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, ToolData

from tests.drawing.cell import at
from tests.drawing.conftest import FRONT, HEIGHT, WIDTH, Stage

pytestmark = pytest.mark.long

BACKGROUND = np.array([51, 102, 153])


def painted(geometry: Geometry, red: float, green: float, blue: float, alpha: float = 1.0) -> Figure:
    return Figure(geometry, material=Material((red, green, blue, alpha)))


def is_red(color: np.ndarray) -> bool:
    return color[0] > 120 and color[0] > 2.5 * max(color[1], color[2])


def is_green(color: np.ndarray) -> bool:
    return color[1] > 90 and color[1] > 1.5 * max(color[0], color[2])


def is_background(color: np.ndarray) -> bool:
    return bool(np.abs(color - BACKGROUND).max() <= 2)


def foreground(stage: Stage) -> np.ndarray:
    """Return (HEIGHT, WIDTH) whether there is something before the background."""
    return np.abs(stage.pixels().astype(int) - BACKGROUND).max(axis=2) > 12


def test_a_red_box_is_seen_where_it_is_and_follows_its_node(stage: Stage) -> None:
    stage.cell.add("box", painted(Box((0.5, 0.5, 0.5)), 1.0, 0.0, 0.0))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))
    assert is_background(stage.pixel(1.0, 0.0))
    stage.cell.do(UpdateNode("box", parent_t_node=at(1.0, 0.0, 0.8)))
    stage.wait(lambda: is_red(stage.pixel(1.0, 0.8)))
    assert is_background(stage.pixel(0.0, 0.0))
    stage.cell.do(RemoveNode("box"))
    stage.wait(lambda: not foreground(stage).any())


@pytest.mark.parametrize(
    ("geometry", "area"),
    # The outlines as seen from the side, by formula: square, circle, rectangle, triangle, rectangle and circle.
    [
        (Box((1.0, 0.1, 1.2)), 1.2),
        (Sphere(0.6), np.pi * 0.36),
        (Cylinder(0.4, 1.2), 0.96),
        (Cone(0.6, 1.2), 0.72),
        (Capsule(0.3, 0.8), 0.48 + np.pi * 0.09),
    ],
)
def test_primitives_have_their_size(stage: Stage, geometry: Geometry, area: float) -> None:
    """From 40 m away through a narrow lens, so that perspective adds next to nothing."""
    view = Camera((0.0, -40.0, 0.0), (0.0, 0.0, 0.0), 0.05)
    stage.view.update(camera=view)
    stage.cell.add("shape", painted(geometry, 1.0, 0.0, 0.0))
    pixels_a_meter = 0.5 * HEIGHT / np.tan(0.5 * view.field_of_view) / 40.0

    def seen() -> bool:
        return abs(foreground(stage).sum() / pixels_a_meter**2 / area - 1.0) < 0.04

    stage.wait(seen)


def test_the_background_has_its_exact_colour(stage: Stage) -> None:
    stage.view.update(background=(1.0, 0.5, 0.0))
    stage.wait(lambda: np.abs(stage.pixels().astype(int) - (255, 128, 0)).max() <= 2)


def test_the_grid_comes_and_goes(stage: Stage) -> None:
    stage.view.update(grid_hidden=False, camera=Camera((0.0, -4.0, 2.0), (0.0, 0.0, 0.0), 0.9))
    stage.wait(lambda: foreground(stage).any())
    stage.view.update(grid_hidden=True)
    stage.wait(lambda: not foreground(stage).any())


def test_the_camera_goes_where_it_is_told_and_tells_so(stage: Stage) -> None:
    stage.cell.add("ahead", painted(Box((0.5, 0.5, 0.5)), 1.0, 0.0, 0.0))
    stage.cell.add("behind", painted(Box((0.5, 0.5, 0.5)), 0.0, 1.0, 0.0), pose=at(0.0, -8.0, 0.0))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))
    stage.view.update(camera=Camera(FRONT.position, (0.0, -8.0, 0.0), 0.9))
    stage.wait(lambda: is_green(stage.pixel(0.0, 0.0)))
    stage.view.update(camera=Camera((0.0, 0.0, 6.0), (0.0, 0.0, 0.0), 0.9))  # straight down, where up is not defined
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))


def test_hiding_a_node_hides_what_is_below_it(stage: Stage) -> None:
    stage.cell.add("parent", painted(Box((0.4, 0.4, 0.4)), 1.0, 0.0, 0.0))
    stage.cell.add("child", painted(Box((0.4, 0.4, 0.4)), 0.0, 1.0, 0.0), parent="parent", pose=at(1.0, 0.0, 0.0))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)) and is_green(stage.pixel(1.0, 0.0)))
    stage.cell.do(UpdateNode("parent", hidden=True))
    stage.wait(lambda: not foreground(stage).any())
    stage.cell.do(UpdateNode("parent", hidden=False))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)) and is_green(stage.pixel(1.0, 0.0)))
    stage.cell.do(UpdateNode("child", hidden=True))
    stage.wait(lambda: is_background(stage.pixel(1.0, 0.0)))
    assert is_red(stage.pixel(0.0, 0.0))


def test_instances_of_one_batch_come_and_go_one_by_one(stage: Stage) -> None:
    places = {f"box{index}": 0.5 * (index - 2) for index in range(5)}
    for name, x in places.items():
        stage.cell.add(name, painted(Box((0.3, 0.3, 0.3)), 1.0, 0.0, 0.0), pose=at(x, 0.0, 0.0))
    stage.wait(lambda: all(is_red(stage.pixel(x, 0.0)) for x in places.values()))
    stage.cell.do(RemoveNode("box1"))
    stage.wait(lambda: [is_red(stage.pixel(x, 0.0)) for x in places.values()] == [True, False, True, True, True])
    stage.cell.add("late", painted(Box((0.3, 0.3, 0.3)), 1.0, 0.0, 0.0), pose=at(0.0, 0.0, 1.0))
    stage.wait(lambda: is_red(stage.pixel(0.0, 1.0)))
    assert is_red(stage.pixel(1.0, 0.0))


def test_points_lines_and_frames_follow_their_node(stage: Stage) -> None:
    points = np.array([[-1.0, 0.0, 0.0]])
    line = np.array([[[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]])
    stage.cell.add(
        "marks",
        Figure(Points(points.tobytes(), np.array([[255, 0, 0]], np.uint8).tobytes(), size=0.2)),
        Figure(Lines(line.tobytes(), width=8.0), material=Material((0.0, 1.0, 0.0, 1.0))),
        Figure(Frame(1.0), at(0.8, 0.0, 0.0)),
        kind=Kind.ANNOTATION,
    )
    stage.wait(lambda: is_red(stage.pixel(-1.0, 0.0)) and is_green(stage.pixel(0.0, 0.3)))
    assert is_red(stage.pixel(-1.08, 0.0)) and is_background(stage.pixel(-1.13, 0.0))  # 0.2 m wide
    stage.wait(lambda: is_red(stage.pixel(1.7, 0.0)))  # the head of x
    up = stage.pixel(0.8, 0.9)  # the head of z
    assert up[2] > up[0] and up[2] > 120 and not is_background(up)
    stage.cell.do(UpdateNode("marks", parent_t_node=at(0.0, 0.0, 0.6)))
    stage.wait(lambda: is_red(stage.pixel(-1.0, 0.6)) and is_green(stage.pixel(0.0, 0.9)))
    assert is_background(stage.pixel(-1.0, 0.0)) and is_background(stage.pixel(0.0, -0.3))
    stage.cell.do(RemoveNode("marks"))
    stage.wait(lambda: not foreground(stage).any())


def test_a_label_is_written_and_wiped(stage: Stage) -> None:
    stage.cell.add("words", Figure(Label("pallet 1")), kind=Kind.ANNOTATION)
    stage.wait(lambda: foreground(stage).sum() > 100)
    rows, columns = np.nonzero(foreground(stage))
    assert abs(columns.mean() - 0.5 * WIDTH) < 20 and abs(rows.mean() - 0.5 * HEIGHT) < 40
    stage.cell.do(RemoveNode("words"))
    stage.wait(lambda: not foreground(stage).any())


def add_arm(stage: Stage) -> None:
    """Add a robot whose one link, a green bar of 1 m along x, turns about y, away from the eye."""
    stage.cell.add("arm", kind=Kind.ROBOT)
    joint = Joint("turn", JointType.REVOLUTE, (0.0, 1.0, 0.0))
    bar = Figure(Box((1.0, 0.1, 0.1)), at(0.5, 0.0, 0.0), Material((0.0, 1.0, 0.0, 1.0)))
    stage.cell.add("bar", bar, parent="arm", kind=Kind.LINK, data=LinkData(joint))


def test_a_joint_turns_its_link_and_shows_its_axis(stage: Stage) -> None:
    add_arm(stage)
    stage.wait(lambda: is_green(stage.pixel(0.8, 0.0)))
    stage.cell.do(SetJointPositions("arm", {"turn": -np.pi / 2.0}))
    stage.wait(lambda: is_green(stage.pixel(0.0, 0.8)))
    assert is_background(stage.pixel(0.8, 0.0))
    stage.view.update(camera=Camera((4.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.9))  # now y goes right
    stage.wait(lambda: is_background(stage.pixel(0.45, 0.0)) and is_green(stage.pixel(0.0, 0.8)))
    stage.view.update(joint_axes=(stage.cell.uid("arm"),))
    # The arrow reaches 1.5 times the link's length to both sides of the joint; its head is at +y.
    stage.wait(lambda: not is_background(stage.pixel(1.45, 0.0)) and not is_background(stage.pixel(-1.45, 0.0)))
    assert is_background(stage.pixel(1.45, 0.08)) and is_background(stage.pixel(1.65, 0.0))
    stage.view.update(joint_axes=())
    stage.wait(lambda: is_background(stage.pixel(1.45, 0.0)))


def test_a_bounding_box_follows_the_arm_in_the_robots_frame(stage: Stage) -> None:
    add_arm(stage)
    stage.wait(lambda: is_green(stage.pixel(0.8, 0.0)))

    def extent() -> tuple[float, float]:
        """Return how far right and how far up anything is seen, in meters at 4 m from the eye."""
        rows, columns = np.nonzero(foreground(stage))
        scale = 0.5 * HEIGHT / np.tan(0.45) / 4.0
        return (columns.max() - 0.5 * WIDTH) / scale, (0.5 * HEIGHT - rows.min()) / scale

    # Turned by -45 degrees the bar reaches to x = z = (1 + 0.05) / sqrt(2) or so: so does its box, with a corner there.
    stage.cell.do(SetJointPositions("arm", {"turn": -np.pi / 4.0}))
    stage.view.update(bounding_boxes=(stage.cell.uid("arm"),))
    far = (1.0 + 0.05) / np.sqrt(2.0)

    def corner() -> bool:
        window = [stage.pixel(far + dx, far + dz) for dx in (0.0, 0.01, 0.02) for dz in (0.0, 0.01, 0.02)]
        return any(color[0] > 150 and color[0] > color[2] + 60 for color in window)

    stage.wait(corner)
    assert extent() == (pytest.approx(far, abs=0.06), pytest.approx(far, abs=0.06))
    stage.view.update(bounding_boxes=())
    stage.wait(lambda: not corner())


def test_a_measurement_is_a_line_that_follows_its_node(stage: Stage) -> None:
    def crimson(x: float, z: float) -> bool:
        rows = [stage.pixel(x, z + dz) for dz in (-0.01, 0.0, 0.01)]
        return any(color[0] > 150 and max(color[1:]) < 110 for color in rows)

    # The label stands above the middle of the line, so the first quarter is looked at.
    stage.cell.add("end")
    measurement = Measurement("reach", NodePoint(1, (0.0, 0.0, 0.0)), NodePoint(stage.cell.uid("end"), (1.2, 0.0, 0.0)))
    stage.view.update(measurements=(measurement,))
    stage.wait(lambda: crimson(0.3, 0.0))
    stage.cell.do(UpdateNode("end", parent_t_node=at(-1.2, 0.0, 1.2)))
    stage.wait(lambda: crimson(0.0, 0.3) and not crimson(0.3, 0.0))
    stage.view.update(measurements=())
    stage.wait(lambda: not crimson(0.0, 0.3))


def test_a_tool_shows_the_figures_of_its_state(stage: Stage) -> None:
    figures = (
        Figure(Box((0.5, 0.5, 0.5)), material=Material((1.0, 0.0, 0.0, 1.0)), tool_state="open"),
        Figure(Box((0.5, 0.5, 0.5)), material=Material((0.0, 1.0, 0.0, 1.0)), tool_state="closed"),
    )
    stage.cell.add("tool", *figures, kind=Kind.TOOL, data=ToolData(states={"open": {}, "closed": {}}))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))
    stage.cell.do(SetToolState("tool", "closed"))
    stage.wait(lambda: is_green(stage.pixel(0.0, 0.0)))
    stage.cell.do(SetToolState("tool", "open"))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))


def test_what_is_translucent_lets_through_what_is_behind(stage: Stage) -> None:
    stage.cell.add("glass", painted(Box((0.5, 0.5, 0.5)), 1.0, 1.0, 1.0, 0.4))
    stage.cell.add("behind", painted(Box((0.2, 0.2, 0.2)), 1.0, 0.0, 0.0), pose=at(0.0, 1.0, 0.0))
    stage.wait(lambda: not is_background(stage.pixel(0.2, 0.2)))
    stage.wait(lambda: stage.pixel(0.0, 0.0)[0] > stage.pixel(0.0, 0.0)[1] + 30)


def square(x: float, **look: object) -> Submesh:
    """Return an upright square of 0.6 m about x, facing the eye, its corners counter-clockwise from lower left."""
    half = 0.3
    corners = np.array([[x - half, 0, -half], [x + half, 0, -half], [x + half, 0, half], [x - half, 0, half]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Submesh(corners.astype(np.float32), faces, **look)  # pyright: ignore[reportArgumentType]  the test's own


def test_a_mesh_shows_its_texture_and_its_vertex_colours(stage: Stage) -> None:
    image = Image.new("RGB", (2, 2), (255, 0, 0))
    image.putpixel((0, 0), (0, 255, 0))  # upper left
    png = io.BytesIO()
    image.resize((64, 64), Image.Resampling.NEAREST).save(png, "PNG")
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    colors = np.array([[255, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [0, 255, 0, 255]], np.uint8)
    parts = (square(-1.0, uv=uv, texture=png.getvalue()), square(1.0, vertex_colors=colors))
    stage.cell.told["memory.obj"] = parts
    stage.cell.add("mesh", Figure(Mesh("memory.obj", "1" * 64)))
    stage.wait(lambda: is_green(stage.pixel(-1.2, 0.2)) and is_red(stage.pixel(-0.8, 0.2)))
    assert is_red(stage.pixel(-1.2, -0.2))
    assert is_green(stage.pixel(1.0, 0.25)) and is_red(stage.pixel(1.0, -0.25))


def test_a_broken_mesh_leaves_the_rest_to_be_seen(stage: Stage) -> None:
    stage.cell.add("broken", Figure(Mesh("nowhere.stl", "0" * 64)))
    stage.cell.add("box", painted(Box((0.5, 0.5, 0.5)), 1.0, 0.0, 0.0))
    stage.wait(lambda: is_red(stage.pixel(0.0, 0.0)))


def test_real_robots_are_seen(stage: Stage) -> None:
    """An iiwa and a Panda of pybullet_data stand where they were put, about as high as their data sheets say."""
    stage.cell.load("kuka_iiwa/model.urdf", "iiwa", at(-0.8, 0.0, -0.6))
    stage.cell.load("franka_panda/panda.urdf", "panda", at(0.8, 0.0, -0.6))
    # Upright, the LBR iiwa 14 is 1.306 m to its flange; the Panda reaches 1.19 m at its highest with straight joints.
    stage.wait(lambda: foreground(stage)[:, : WIDTH // 2].any() and foreground(stage)[:, WIDTH // 2 :].any())
    scale = 0.5 * HEIGHT / np.tan(0.45) / 4.0

    def height(half: slice) -> float:
        rows = np.nonzero(foreground(stage)[:, half])[0]
        return (rows.max() - rows.min()) / scale

    stage.wait(lambda: height(slice(0, WIDTH // 2)) == pytest.approx(1.306, abs=0.12))
    stage.wait(lambda: height(slice(WIDTH // 2, WIDTH)) > 0.9)
