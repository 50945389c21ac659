"""Files that go the whole way: translated by the bundled importers and read by the kernel's own readers."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, TranslatedScene, import_model
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import Kind, PartData
from virtualrobot_plugins.importers import virtualrobot_register_importers
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.models import Model

from tests.unit.formats.models import DATA, disk, uploaded
from tests.unit.plugins.importers.reading import FILES

DOCS = Path(__file__).parents[4] / "docs" / "formats.md"


class Bundled:
    """The bundled importers, called in this process."""

    def __init__(self) -> None:
        """Ask the plugin which there are."""
        self._made: dict[str, tuple[Callable[..., Any], type | None]] = {}

        def register(
            name: str,
            factory: Callable[..., Any],
            endings: Sequence[str],
            config_type: type | None = None,
            **options: object,
        ) -> None:
            self._made.update((ending, (factory, config_type)) for ending in endings)

        virtualrobot_register_importers(register)

    @property
    def models(self) -> Mapping[str, Model]:
        return {}

    @property
    def endings(self) -> tuple[str, ...]:
        return tuple(self._made)

    def translate(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Mapping[str, Any]
    ) -> Translation:
        factory, config_type = self._made["." + uri.rpartition(".")[2].lower()]
        importer = factory() if config_type is None else factory(config_type(**settings))
        return importer.translate(data, uri, files)


def imported(
    path: Path,
    files: Files | None = None,
    **options: Any,  # noqa: ANN401  those of `import_model`
) -> tuple[ImportedModel | TranslatedScene, MeshLibrary]:
    files = files or disk()
    library = MeshLibrary(files.store, Bundled())
    return import_model(str(path), files, library, **options), library


@pytest.mark.parametrize(
    ("name", "settings", "size"),
    [
        ("torus.dxf", {"unit_meters": 1.0}, (0.8, 0.8, 0.2)),
        ("torus.wrl", {}, (0.8, 0.8, 0.2)),
        ("torus.ply", {}, (0.8, 0.8, 0.2)),
        ("torus.off", {}, (0.8, 0.8, 0.2)),
        ("bored_block.step", {"linear_tolerance_meters": 1e-4}, (0.06, 0.04, 0.02)),
        ("pinned_plate.3mf", {}, (4 * 0.0254, 2 * 0.0254, 1.5 * 0.0254)),
    ],
)
def test_a_mesh_becomes_a_part(name: str, settings: dict[str, Any], size: tuple[float, float, float]) -> None:
    model, library = imported(FILES / name, as_part=True, scale=(1.0, 2.0, -1.0), settings=settings)
    assert isinstance(model, ImportedModel)
    (node,) = model.nodes
    assert node.kind is Kind.PART and isinstance(node.data, PartData) and node.name == name.partition(".")[0]
    mesh = node.figures[0].geometry
    assert isinstance(mesh, Mesh)
    points = np.concatenate([part.vertices[part.faces].reshape(-1, 3) for part in library.load(mesh)])
    assert np.ptp(points, axis=0) == pytest.approx(np.array(size) * [1.0, 2.0, 1.0], rel=1e-5)


def test_a_robot_in_sdformat_becomes_a_scene() -> None:
    scene, _ = imported(DATA / "kuka_iiwa/kuka_with_gripper.sdf")
    assert isinstance(scene, TranslatedScene)
    message = scene_file.parse(scene.text)
    assert message.nodes[0].WhichOneof("kind") == "robot"
    meshes = [figure.mesh.uri for node in message.nodes for figure in node.figures if figure.HasField("mesh")]
    files = disk()
    for uri in meshes:
        assert files.read(uri, scene.uri).data


def test_an_inlined_world_and_its_texture_come_from_the_upload() -> None:
    head = b"#VRML V2.0 utf8\n"
    contents = {
        "cell/main.wrl": head + b'Inline { url "parts/box.wrl" }',
        "cell/parts/box.wrl": head + b"Shape { geometry Box { size 1 2 3 } }",
    }
    model, library = imported(Path("cell/main.wrl"), uploaded(contents))
    assert isinstance(model, ImportedModel)
    mesh = model.nodes[0].figures[0].geometry
    assert isinstance(mesh, Mesh)
    assert sum(len(part.faces) for part in library.load(mesh)) == 12


def test_the_errors_in_the_docs_are_those_that_come() -> None:
    told = DOCS.read_text()
    lines = "\n" * 10
    files = {
        "cell.wrl": f"#VRML V2.0 utf8{lines}\nShape {{ geometry Box {{ size 1 2 }} }}",
        "world.sdf": '<sdf version="1.9"><model name="m"><link name="a"/><link name="b"/>' + "\n" * 40
        + '<joint name="elbow" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 0</xyz></axis></joint>'
        + "</model></sdf>",
    }  # fmt: skip
    for name, text in files.items():
        with pytest.raises(MalformedFileError) as caught:
            imported(Path(name), uploaded({name: text.encode()}))
        assert f"      {caught.value}\n" in told
