"""A world saved and loaded is the same world: as a file on this machine, and as a bundle on another one."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.scene_writer import to_plain
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.scenes.reading import read_scene
from virtualrobot_kernel.scenes.writing import write_scene
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetJointPositions
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import JointType

from tests.tiers import every_fifth
from tests.unit.formats.models import DATA, ROBOTS, XacroOnly, disk, imported


class Bench:
    """A world with an asset store of its own, as one kernel has them."""

    def __init__(self) -> None:
        """Begin empty, with time standing still."""
        self.meshes = MeshLibrary(AssetStore(), XacroOnly())
        self.world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
        self.world.start()

    def apply(self, commands: Sequence[Command]) -> Snapshot:
        """Apply a batch and return the world after it."""
        return self.world.submit(commands).result(60).snapshot

    def load(self, file: Path) -> Snapshot:
        """Load a scene file."""
        return self.apply(read_scene(file.read_text(), str(file), disk(self.meshes.store), self.meshes)[0])

    def save(self, file: Path, bundled: bool) -> None:
        """Save a scene file and what belongs beside it."""
        text, files = write_scene(self.world.snapshot, bundled)
        for path, sha256 in files:
            (file.parent / path).parent.mkdir(parents=True, exist_ok=True)
            (file.parent / path).write_bytes(self.meshes.store.get(sha256))
        file.write_text(text)


@pytest.fixture
def benches() -> Iterator[list[Bench]]:
    made = [Bench(), Bench()]
    yield made
    for bench in made:
        bench.world.close()


def filled(bench: Bench, rng: np.random.Generator) -> None:
    """Fill the world with robots on bases of all sorts, in random postures, and a scaled, mirrored mesh."""
    files = disk(bench.meshes.store)
    bases = {"panda": JointType.FIXED, "xarm6_gripper": JointType.FIXED, "a1": JointType.FLOATING}
    for name, base in {**bases, "husky": JointType.PLANAR, "r2d2": JointType.FIXED}.items():
        model = imported(str(ROBOTS[name]), files, bench.meshes, name=f"{name} no. 1", base_joint=base)
        bench.apply([CreateNodes(model.nodes)])
    duck = imported(str(DATA / "duck.obj"), files, bench.meshes, name="on", scale=(0.01, -0.01, 0.02))
    bench.apply([CreateNodes(duck.nodes)])
    structure = bench.world.snapshot.structure
    for robot in structure.robots.values():
        q = []
        for joint in robot.joints:
            if joint.type is JointType.FLOATING:
                turn = rng.normal(size=4)
                turn *= np.sign(turn[3]) / np.linalg.norm(turn)
                q += [*rng.uniform(-2, 2, 3), *turn]
            elif joint.type is JointType.PLANAR:
                q += [*rng.uniform(-2, 2, 3)]
            else:
                lower, upper = np.clip([joint.limits.lower, joint.limits.upper], -3.0, 3.0)
                q.append(rng.uniform(lower, upper))
        bench.apply([SetJointPositions(structure.nodes[robot.uid].name, coordinates=np.array(q))])


def mesh_contents(snapshot: Snapshot) -> list[tuple[str, str, tuple[float, float, float], list[str]]]:
    """Return what each mesh figure of each node is, but for where its file lies."""
    figures: list[tuple[str, Figure]] = [
        (node.name, figure) for node in snapshot.structure.nodes.values() for figure in node.figures
    ]
    return [
        (name, mesh.sha256, mesh.scale, [sha256 for _, sha256 in mesh.files])
        for name, mesh in ((name, figure.geometry) for name, figure in figures)
        if isinstance(mesh, Mesh)
    ]


def flat(text: str) -> tuple[dict[str, float], dict[str, object]]:
    """Return the numbers of a scene file by place, and everything else by place."""
    numbers: dict[str, float] = {}
    words: dict[str, object] = {}

    def walk(value: object, place: str) -> None:
        if isinstance(value, dict):
            words[f"{place} has"] = sorted(key for key, item in value.items() if not isinstance(item, float))
            for key, item in value.items():
                walk(item, f"{place}.{key}")
        elif isinstance(value, list):
            words[f"{place} has"] = len(value)
            for i, item in enumerate(value):
                walk(item, f"{place}[{i}]")
        elif isinstance(value, float):
            numbers[place] = value
        else:
            words[place] = value

    walk(to_plain(scene_file.parse(text)), "")
    return numbers, words


@pytest.mark.long
@pytest.mark.parametrize("bundled", every_fifth([True, False]))
def test_saved_and_loaded_is_the_same(
    bundled: bool, benches: list[Bench], tmp_path: Path, rng: np.random.Generator
) -> None:
    first, second = benches
    filled(first, rng)
    (tmp_path / "a").mkdir()
    first.save(tmp_path / "a/cell.yaml", bundled)
    if bundled:
        # The folder has moved, so that nothing can come from where it was first.
        assert str(DATA) not in (tmp_path / "a/cell.yaml").read_text().replace("source: " + str(DATA), "")
        (tmp_path / "a").rename(tmp_path / "b")
    file = tmp_path / ("b" if bundled else "a") / "cell.yaml"
    before, after = first.world.snapshot, second.load(file)
    assert [node.name for node in before.structure.nodes.values()] == [
        node.name for node in after.structure.nodes.values()
    ]
    assert np.abs(before.world_t_node - after.world_t_node).max() < 1e-12
    assert before.state.q.tolist() == pytest.approx(after.state.q.tolist(), abs=1e-15)
    assert mesh_contents(before) == mesh_contents(after) and len(mesh_contents(before)) > 70
    # What is written of the loaded world is what was loaded; quaternions cost a last digit.
    numbers, words = flat(file.read_text())
    numbers_again, words_again = flat(write_scene(after, bundled)[0])
    assert words == words_again
    places = numbers.keys() | numbers_again.keys()
    assert len(places) > 1000
    assert max(abs(numbers.get(place, 0.0) - numbers_again.get(place, 0.0)) for place in places) < 1e-14


def test_a_scene_by_hand_loads_models_of_their_own_files(benches: list[Bench], tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/box.obj").write_bytes((DATA / "cube.obj").read_bytes())
    page = Path(__file__).parents[3] / "docs/scene-file.md"
    example = page.read_text().partition("```yaml\n")[2].partition("```")[0]
    (tmp_path / "cell.yaml").write_text(example)
    snapshot = benches[0].load(tmp_path / "cell.yaml")
    names = [node.name for node in snapshot.structure.nodes.values()]
    assert names[:4] == ["world", "table", "box 1", "arm"] and "arm.lbr_iiwa_link_7" in names
    assert snapshot.state.q.tolist() == [0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]
    assert list(snapshot.state.signals) == ["box_at_end"]
