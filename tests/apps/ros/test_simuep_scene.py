"""Scene files of SimUEP-Robotics as scene files of a kernel: figure 3 of the document, all other elements, bad ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot.errors import MalformedFileError, MissingFileError
from virtualrobot_apps.bridges.ros.simuep.elements import parse_elements, read_elements
from virtualrobot_apps.bridges.ros.simuep.scene import SimuepScene, scene_of
from virtualrobot_apps.bridges.ros.simuep.topics import choice_of, lines_of

FIGURE_3 = """<robots prefix="SimUEP">
  <services>
    <draw3DLines name="drawPathService"/>
    <enableSensor name="enableSensorService"/>
    <cameraInfo name="setCameraInfoService"/>
  </services>
  <robot name="Puma560">
    <urdf fileName="Data/Urdfs/Puma_560.urdf"/>
    <transform position="0.0 0.0 -0.363" rotation="0 0 0" scale="1 1 1"/>
    <actuators>
      <joint><topicName name="jointState"/></joint>
    </actuators>
    <sensors>
      <joint><topicName name="jointStateReal"/></joint>
      <collision><topicName name="collision"/><precision mode="high" defaultValue="1.5"/></collision>
      <proximity><topicName name="proximity"/><range value="0.10"/></proximity>
    </sensors>
  </robot>
</robots>"""
"""Figure 3 of the document, its tags closed where its text lost that."""

WHOLE = """<scene>
  <displaySettings near="0.1" far="1000"/>
  <physicsSettings updateFrequency="1000" gravity="0 0 -1.62"/>
  <observer height="1.7" speed="2"><transform position="-3 0 0.5" rotation="0 0 1.5707963267948966"/></observer>
  <lights>
    <light name="sun" type="directional" color="1 0.5 0" intensity="2" shadow="none"/>
    <light type="spot" angle="1.0"><transform position="0 0 3" rotation="3.141592653589793 0 0"/></light>
  </lights>
  <envObjects>
    <envObject name="table">
      <transform position="1 2 3" scale="2 1 1"/>
      <boundingBox size="0.5 1 2" center="0.25 0 0"/>
      <mesh fileName="meshes/table.obj"/>
      <material friction="0.7" bounciness="0.2" color="1 0 0"/>
    </envObject>
    <envObject name="prism">
      <boundingBox size="0.1 0.2 0.3"/>
      <physics mass="0.4" inertia="1 0 0.1 0 2 0 0.1 0 3"/>
    </envObject>
  </envObjects>
</scene>"""


def scene(text: str) -> SimuepScene:
    return scene_of(parse_elements(text.encode(), "scene.xml"))


def test_figure_3_gives_the_puma_its_topics_and_services() -> None:
    found = scene(FIGURE_3)
    assert found.prefix == "SimUEP"
    assert found.services == {
        "draw3DLines": "drawPathService",
        "enableSensor": "enableSensorService",
        "cameraInfo": "setCameraInfoService",
    }
    (model,) = found.scene["models"]
    assert (model["uri"], model["name"]) == ("Data/Urdfs/Puma_560.urdf", "Puma560")
    assert model["parent_t_node"]["position"] == {"x": 0.0, "y": 0.0, "z": -0.363}
    feeling = {one["name"]: one["contact_sensor"] for one in found.scene["nodes"]}
    assert feeling == {
        "Puma560.collision": {"watched": "Puma560"},
        "Puma560.proximity": {"watched": "Puma560", "range_meters": 0.10},
    }
    entries = {one.topic: (one.type, one.stream) for one in choice_of(found, True).entries}
    assert entries == {
        "/SimUEP/Puma560/jointStateReal": ("sensor_msgs/msg/JointState", "/robots/Puma560/joint_states"),
        "/SimUEP/Puma560/collision": ("sensor_msgs/msg/PointCloud2", "/sensors/Puma560.collision/reading"),
        "/SimUEP/Puma560/proximity": ("std_msgs/msg/String", "/sensors/Puma560.proximity/reading"),
    }
    assert list(lines_of(found)) == [
        ("/SimUEP/Puma560/jointState", "sensor_msgs/msg/JointState", "to Puma560"),
        ("/SimUEP/drawPathService", "virtualrobot_msgs/srv/DrawLines", "service"),
        ("/SimUEP/enableSensorService", "virtualrobot_msgs/srv/EnableSensor", "service"),
        ("/SimUEP/setCameraInfoService", "sensor_msgs/srv/SetCameraInfo", "service"),
    ]
    assert [one.split(":")[1] for one in found.left_out] == ["15"]  # the precision


def test_all_other_elements_stand_in_the_world() -> None:
    found = scene(WHOLE)
    sun, spot, table, prism = found.scene["nodes"]
    assert sun["light"] == {
        "kind": "LIGHT_KIND_DIRECTIONAL",
        "color": {"red": 1.0, "green": 0.5, "blue": 0.0},
        "intensity": 2.0,
        "shadowless": True,
    }
    assert spot["name"] == "light 2" and spot["light"]["cone_angle_radians"] == 0.5
    assert abs(spot["parent_t_node"]["orientation"]["x"]) == pytest.approx(1.0)  # down: half a turn about x

    seen, collides = table["figures"]
    assert seen["mesh"] == {"uri": "meshes/table.obj", "scale": {"x": 2.0, "y": 1.0, "z": 1.0}}
    assert collides["box"]["size"] == {"x": 1.0, "y": 1.0, "z": 2.0}
    assert collides["node_t_figure"]["position"]["x"] == 0.5
    assert (seen["roles"], collides["roles"]) == (["FIGURE_ROLE_VISUAL"], ["FIGURE_ROLE_COLLISION"])
    assert seen["material"]["friction"] == 0.7 and seen["material"]["restitution"] == 0.2
    assert "object" in table

    inertial = prism["part"]["inertial"]
    assert (prism["part"]["mass_kilograms"], prism["part"]["dynamic"]) == (0.4, True)
    assert inertial["diagonal"] == {"x": 1.0, "y": 2.0, "z": 3.0}
    assert inertial["products"] == {"x": 0.0, "y": 0.1, "z": 0.0}
    # 1000 steps a second are 4 in each tick of 4 ms.
    assert found.scene["physics"] == {"gravity": {"x": 0.0, "y": 0.0, "z": -1.62}, "engine": "mujoco", "substeps": 4}

    assert found.observer is not None
    np.testing.assert_allclose(found.observer[:3, 3], [-3.0, 0.0, 2.2])
    np.testing.assert_allclose(found.observer[:3, 0], [0.0, 1.0, 0.0], atol=1e-15)  # it looks along y


def test_without_a_mass_nothing_moves_by_forces() -> None:
    found = scene('<scene><envObjects><envObject name="a"><boundingBox size="1 1 1"/></envObject></envObjects></scene>')
    assert "physics" not in found.scene


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("<lights>", "<lihgts>", "no XML: mismatched tag"),
        ('type="spot"', 'type="spotty"', "scene.xml:7: <light>: 'type' is point, spot, directional, not 'spotty'"),
        ('angle="1.0"', 'angel="1.0"', "no attribute 'angel'; did you mean 'angle'? known:"),
        ('color="1 0.5 0"', 'color="255 0 0"', "'color' has red, green and blue in parts of 0 to 1"),
        ('position="1 2 3"', 'position="1 2"', "scene.xml:11: <transform>: 'position' is 3 numbers, not '1 2'"),
        ('position="1 2 3"', 'position="1 2 nan"', "'position' is 3 numbers, not '1 2 nan'"),
        ('rotation="0 0 1.5707963267948966"', 'rotation="0 0 90"', "scene.xml:4: <transform>:"),
        ('scale="2 1 1"', 'scale="0 1 1"', "'scale' has three factors other than 0"),
        ('size="0.1 0.2 0.3"', 'size="0.1 0 0.3"', "'size' has edges above 0"),
        ('mass="0.4"', 'mass="-1"', "'mass' is 0 at least, not -1"),
        ('inertia="1 0 0.1 0 2 0 0.1 0 3"', 'inertia="1 0 0 0 2 0 0.1 0 3"', "'inertia' is a symmetric matrix"),
        ('bounciness="0.2"', 'bounciness="2"', "'bounciness' is 0 to 1, not 2"),
        ('<envObject name="prism">', "<envObject>", "scene.xml:16: <envObject>: the attribute 'name' is missing"),
        ("<envObjects>", "<envObjects><wall/>", "there is no element 'wall'; known: envObject"),
        ("<scene>", '<!DOCTYPE a [<!ENTITY b "c">]><scene>', "a scene declares no entities"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(old: str, new: str, says: str) -> None:
    assert old in WHOLE
    with pytest.raises(MalformedFileError) as told:
        scene(WHOLE.replace(old, new, 1))
    assert says in str(told.value) and str(told.value).startswith("scene.xml:")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('<urdf fileName="Data/Urdfs/Puma_560.urdf"/>', "", "scene.xml:7: <robot>: the element <urdf> is missing"),
        ('scale="1 1 1"', 'scale="2 2 2"', "'scale' of a robot is 1 1 1 here"),
        ('<range value="0.10"/>', "", "<proximity>: the element <range> is missing"),
        ('<topicName name="proximity"/>', "", "<proximity>: the element <topicName> is missing"),
        ("<collision>", "<colision>", "no XML"),
        ("<draw3DLines", "<draw3dLines", "there is no element 'draw3dLines'; did you mean 'draw3DLines'?"),
    ],
)
def test_what_is_wrong_with_robots_is_told(old: str, new: str, says: str) -> None:
    assert old in FIGURE_3
    with pytest.raises(MalformedFileError) as told:
        scene(FIGURE_3.replace(old, new, 1))
    assert says in str(told.value)


def test_elements_without_end_and_files_that_are_not_there(tmp_path) -> None:  # noqa: ANN001
    with pytest.raises(MalformedFileError, match="nested more than 64 deep"):
        parse_elements(b"<a>" * 1000, "deep.xml")
    with pytest.raises(MissingFileError, match=r"nowhere\.xml cannot be read"):
        read_elements(tmp_path / "nowhere.xml")


def test_angles_are_those_of_a_urdf() -> None:
    """Turns about the fixed axes x, y, z: a roll of a quarter turn leaves x, and takes y to z."""
    text = f'<transform position="0 0 0" rotation="{math.pi / 2} 0 0"/>'
    found = scene(WHOLE.replace('<transform position="1 2 3" scale="2 1 1"/>', text))
    turn = found.scene["nodes"][2]["parent_t_node"]["orientation"]
    assert turn == pytest.approx({"x": math.sqrt(0.5), "y": 0.0, "z": 0.0, "w": math.sqrt(0.5)})
