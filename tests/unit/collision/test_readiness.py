"""What a guard needs is made before: which commands ask for it, and that nothing is left to make."""

from __future__ import annotations

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.readiness import is_to_be_ready, make_ready
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, CreateNodes, RemoveNode, SetCollisionSettings, UpdateNode
from virtualrobot_kernel.world.figures import Box, Figure, Mesh, Sphere

from tests.unit.collision.solids import load
from tests.unit.collision.test_scene import body, mover
from tests.unit.collision.worlds import after, world
from tests.unit.world.builders import shifted

ROBOT = CreateNodes((mover("robot", Sphere(0.1), shifted()),))
GUARD = SetCollisionSettings(modes=(("robot", CollisionMode.GUARD),))


def test_only_figures_that_come_to_a_guard_are_made_before() -> None:
    plain = world(ROBOT)
    guarded = after(plain, GUARD)
    new = CreateNodes((body("box", Box((1, 1, 1)), shifted(x=3)),))
    cases: list[tuple[bool, Command]] = [
        (True, new),
        (True, UpdateNode("robot", figures=())),
        (False, RemoveNode("robot")),
        (False, SetCollisionSettings(mode=CollisionMode.STOP)),
    ]
    for wanted, command in cases:
        assert not is_to_be_ready(plain, [command])
        assert is_to_be_ready(guarded, [command]) == wanted
    assert is_to_be_ready(plain, [GUARD]) and is_to_be_ready(plain, [SetCollisionSettings(mode=CollisionMode.GUARD)])


def test_then_nothing_is_left_to_make() -> None:
    """Meshes are loaded while it is made ready, and none when a scene takes the world in."""
    loaded = []

    def loading(mesh: Mesh) -> tuple:
        loaded.append(mesh.uri)
        return load(mesh)

    shapes = CollisionShapes(loading)
    before = after(world(ROBOT), CreateNodes((body("old", Mesh("old.stl", "0" * 64), shifted(x=3)),)))
    commands = [
        CreateNodes((body("new", Mesh("new.stl", "1" * 64), shifted(x=4)),)),
        UpdateNode("old", figures=(Figure(Mesh("other.stl", "2" * 64, collision_hull_vertices=16)),)),
    ]
    make_ready(shapes, before, commands)
    assert sorted(loaded) == ["new.stl", "old.stl", "other.stl"]
    scene = CollisionScene(shapes)
    scene.place(after(before, *commands))
    scene.collisions(Detail.PAIRS)
    assert len(loaded) == 3
