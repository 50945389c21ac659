"""Foreign formats: importers get what they ask for, and their translations work wherever a native file does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest
import trimesh
from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError, Reason
from virtualrobot_kernel.formats import urdf
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import TranslatedScene, import_model
from virtualrobot_kernel.formats.references import list_references
from virtualrobot_kernel.formats.translate import MOST_BYTES, ROUNDS, translate
from virtualrobot_kernel.formats.xml import FileWarning
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData, PartData, RobotData
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation

from tests.unit.formats.models import XacroOnly, imported, uploaded

GLB: Any = trimesh.creation.box((0.1, 0.2, 0.3)).export(file_type="glb")
BOXES = len(trimesh.creation.box().faces)

SHAPE = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
URDF = f'<robot name="r"><link name="a">{SHAPE}</link></robot>'
XACRO = (
    '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">\n<xacro:include filename="$(find p)/m.xacro"/>\n'
    "<xacro:arm/>\n</robot>"
)
MACRO = (
    '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="mesh" default="a.odd"/>'
    '<xacro:macro name="arm"><link name="a"><visual><geometry><mesh filename="$(arg mesh)"/></geometry></visual>'
    "</link></xacro:macro></robot>"
)

Answer = Callable[[bytes, str, Mapping[str, bytes | None]], Translation]


class Odd(XacroOnly):
    """Reads `.odd` files by a function of the test's, and xacro."""

    endings = (".odd", *XacroOnly.endings)

    def __init__(self, answer: Answer = lambda data, uri, files: Translation(".glb", GLB)) -> None:
        """Keep the function; note with what it is asked."""
        self.answer = answer
        self.calls: list[tuple[str, ...]] = []
        self.settings: list[Mapping[str, Any]] = []

    def translate(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Mapping[str, Any]
    ) -> Translation:
        if not uri.endswith(".odd"):
            return super().translate(data, uri, files, settings)
        self.calls.append(tuple(files))
        self.settings.append(settings)
        return self.answer(data, uri, dict(files))


def needs(*names: str) -> Answer:
    """Return an importer's function that asks for one file after the other, and says what it got."""

    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        for name in names:
            if name not in files:
                raise FilesNeeded([name])
        text = b",".join(b"-" if files[name] is None else files[name] or b"" for name in names)
        return Translation(".urdf", b'<robot name="' + text + b'"><link name="a"/></robot>')

    return answer


def bench(answer: Answer, contents: Mapping[str, bytes]) -> tuple[Files, MeshLibrary, Odd]:
    files, odd = uploaded({"d/m.odd": b"data", **contents}), Odd(answer)
    return files, MeshLibrary(files.store, odd), odd


def test_files_are_read_as_the_importer_asks_and_none_is_given_for_what_is_nowhere() -> None:
    files, library, odd = bench(needs("x", "gone", "package://p/y"), {"d/x": b"first", "package://p/y": b"second"})
    model = imported("d/m.odd", files, library)
    assert model.nodes[0].name == "first,-,second"
    assert odd.calls == [(), ("x",), ("x", "gone"), ("x", "gone", "package://p/y")]
    assert isinstance(model.nodes[0].data, RobotData) and model.nodes[0].data.source == "d/m.odd"


def refusing(message: str, **metadata: str) -> Answer:
    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        if "missing" in metadata and metadata["missing"] not in files:
            raise FilesNeeded([metadata["missing"]])
        raise ArgumentError(message, **metadata)

    return answer


def test_an_importers_refusal_names_the_file() -> None:
    files, library, _ = bench(refusing("entity 12 is broken", entity="12"), {})
    with pytest.raises(MalformedFileError, match=r"^m\.odd: entity 12 is broken$") as refused:
        import_model("d/m.odd", files, library)
    assert refused.value.metadata == {"file": "d/m.odd", "entity": "12"}


def test_a_refusal_as_the_kernels_host_passes_it_on_is_the_same() -> None:
    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        raise KernelError("m.odd:3: broken", reason=Reason.INVALID_ARGUMENT)

    files, library, _ = bench(answer, {})
    with pytest.raises(MalformedFileError, match=r"^m\.odd:3: broken$"):
        import_model("d/m.odd", files, library)


def test_a_file_that_the_importer_cannot_do_without_is_missing_with_the_places_tried() -> None:
    files, library, _ = bench(refusing("m.odd: it includes b.inc", missing="b.inc"), {})
    with pytest.raises(MissingFileError, match=r"m\.odd: it includes b\.inc: 'b\.inc', named by d/m\.odd,.*d/b\.inc"):
        import_model("d/m.odd", files, library)


def test_a_fault_of_the_importer_stays_one() -> None:
    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        raise KernelError("it hung", reason=Reason.PLUGIN_FAILED)

    files, library, _ = bench(answer, {})
    with pytest.raises(KernelError, match="it hung") as failed:
        import_model("d/m.odd", files, library)
    assert failed.value.reason is Reason.PLUGIN_FAILED


def again(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
    raise FilesNeeded(["same"])


def endless(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
    raise FilesNeeded([f"file {len(files)}"])


@pytest.mark.parametrize(
    ("answer", "message", "rounds"),
    [(again, "asks again for 'same', which it has", 2), (endless, f"{ROUNDS} in {ROUNDS} rounds", ROUNDS)],
)
def test_an_importer_that_asks_without_end_is_stopped(answer: Answer, message: str, rounds: int) -> None:
    files, _, odd = bench(answer, {})
    with pytest.raises(KernelError, match=message) as failed:
        translate(odd, files.read("d/m.odd"), files)
    assert failed.value.reason is Reason.PLUGIN_FAILED and len(odd.calls) == rounds


def test_a_foreign_mesh_is_a_model_of_its_own_and_one_in_a_urdf() -> None:
    twice = URDF.format("d/m.odd").replace("</link>", SHAPE.format("d/m.odd") + "</link>")
    files, library, odd = bench(Odd().answer, {"r.urdf": twice.encode()})
    thing = imported("d/m.odd", files, library, as_part=True, scale=(2.0, 2.0, 2.0))
    assert (thing.nodes[0].kind, thing.nodes[0].data, thing.nodes[0].name) == (Kind.PART, PartData(), "m")
    mesh = thing.nodes[0].figures[0].geometry
    assert mesh == Mesh("d/m.odd", files.uploaded["d/m.odd"], (2.0, 2.0, 2.0))
    assert isinstance(mesh, Mesh)
    (box,) = library.load(mesh)
    assert box.vertices.max(axis=0) == pytest.approx([0.1, 0.2, 0.3], rel=1e-6)
    robot = imported("r.urdf", files, library)
    assert robot.mesh_count == 2
    # Translated once for each model, never again when drawn.
    calls = len(odd.calls)
    library.load(mesh)
    assert len(odd.calls) == calls == 2
    # Another kernel, such as one that loads the scene, has only the files: it translates them.
    assert [len(part.faces) for part in MeshLibrary(files.store, Odd()).load(mesh)] == [BOXES]


def test_what_a_foreign_mesh_names_belongs_to_the_mesh() -> None:
    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        if "look.png" not in files:
            raise FilesNeeded(["look.png", "gone.png"])
        return Translation(".glb", GLB, ("odd",))

    files, library, _ = bench(answer, {"d/look.png": b"png"})
    mesh, warnings = library.find(files, "d/m.odd")
    assert mesh.files == (("look.png", files.uploaded["d/look.png"]),) and warnings == ("odd",)
    assert MeshLibrary(files.store, Odd(answer)).load(mesh)


def test_a_mesh_translated_with_settings_is_the_translation() -> None:
    files, library, odd = bench(Odd().answer, {})
    model = imported("d/m.odd", files, library, settings={"unit": "inch"})
    mesh = model.nodes[0].figures[0].geometry
    assert odd.settings == [{"unit": "inch"}]
    assert isinstance(mesh, Mesh) and mesh.uri == "d/m.odd.glb" and files.store.get(mesh.sha256) == GLB
    assert MeshLibrary(files.store).load(mesh)  # without any importer


def test_a_scene_is_handed_back_and_is_no_mesh() -> None:
    def answer(data: bytes, uri: str, files: Mapping[str, bytes | None]) -> Translation:
        return Translation(".yaml", b"schema_version: 1\n", ("w",))

    files, library, _ = bench(answer, {"r.urdf": URDF.format("d/m.odd").encode()})
    assert import_model("d/m.odd", files, library) == TranslatedScene(
        "schema_version: 1\n", "d/m.odd", (FileWarning("w"),)
    )
    for option in ({"srdf_uri": "r.srdf"}, {"base_joint": JointType.PLANAR}, {"scale": (1.0, 1.0, -1.0)}):
        with pytest.raises(KernelError, match=r"m\.odd becomes a scene of its own, so .* is not for it"):
            import_model("d/m.odd", files, library, **option)  # pyright: ignore[reportArgumentType]
    with pytest.raises(MalformedFileError, match=r"link 'a': m\.odd: the file holds a scene, which is no mesh"):
        import_model("r.urdf", files, library)


def test_a_broken_translation_is_told_as_such() -> None:
    files, library, _ = bench(lambda data, uri, files: Translation(".glb", b"no"), {})
    with pytest.raises(KernelError, match=r"m\.odd: its translation: "):
        import_model("d/m.odd", files, library)
    files, library, _ = bench(lambda data, uri, files: Translation(".urdf", b"\n<robot/>"), {})
    with pytest.raises(MalformedFileError, match=r"m\.odd:2: the robot has no link \(the line is that of the URDF"):
        import_model("d/m.odd", files, library)


def test_an_ending_that_nothing_reads_is_refused_with_those_that_are() -> None:
    files = uploaded({"a.max": b""})
    with pytest.raises(MalformedFileError, match=r"no model format has the ending '\.max'; known: \.urdf.*\.odd"):
        import_model("a.max", files, MeshLibrary(files.store, Odd()))
    mesh = Mesh("a.max", files.uploaded["a.max"])
    with pytest.raises(MalformedFileError, match=r"no mesh format has the ending '\.max'; known: \.stl.*\.odd"):
        MeshLibrary(files.store, Odd()).load(mesh)


def test_settings_for_a_native_format_are_refused() -> None:
    files = uploaded({"r.urdf": b'<robot name="r"><link name="a"/></robot>'})
    with pytest.raises(KernelError, match=r"settings are an importer's, and \.urdf is read without one"):
        import_model("r.urdf", files, MeshLibrary(files.store, Odd()), settings={"a": 1})


def test_urdf_that_is_xacro_is_expanded_and_other_urdf_is_left_alone() -> None:
    place = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/>'
    place += '<child link="b"/><origin xyz="$(optenv VR_NOWHERE 1 2 3)"/></joint></robot>'
    plain = '<robot name="r" xmlns:xacro="http://x"><link name="a"/><gazebo a="$(arg b)">${c}</gazebo></robot>'
    files = uploaded({"a.urdf": place.encode(), "b.urdf": plain.encode()})
    library = MeshLibrary(files.store, Odd())
    assert imported("a.urdf", files, library).nodes[2].parent_t_node[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert imported("b.urdf", files, library).nodes[1].name == "r.a"
    assert isinstance(imported("b.urdf", files, MeshLibrary(files.store)).nodes[1].data, LinkData)


def test_a_xacro_robot_with_a_foreign_mesh_travels_whole() -> None:
    contents = {"u/r.xacro": XACRO.encode(), "package://p/m.xacro": MACRO.encode(), "u/a.odd": b"", "u/b.odd": b""}
    files = uploaded(contents)
    library = MeshLibrary(files.store, Odd())
    assert imported("u/r.xacro", files, library).mesh_count == 1
    other = imported("u/r.xacro", files, library, settings={"arguments": {"mesh": "b.odd"}})
    mesh = other.nodes[1].figures[0].geometry
    assert isinstance(mesh, Mesh) and mesh.uri == "u/b.odd"


def test_references_come_in_rounds_until_nothing_is_new() -> None:
    data, odd = XACRO.encode(), Odd()
    assert list(list_references(data, "u/r.xacro", odd)) == ["package://p/m.xacro"]
    known = {"package://p/m.xacro": MACRO.encode()}
    assert list(list_references(data, "u/r.xacro", odd, known)) == ["package://p/m.xacro", "a.odd"]
    chosen = {"arguments": {"mesh": "b.odd"}}
    assert list(list_references(data, "u/r.xacro", odd, known, chosen))[1:] == ["b.odd"]
    with pytest.raises(MalformedFileError):
        list_references(data, "u/r.xacro", odd, {"package://p/m.xacro": b"<"})


def test_references_of_an_importer_that_does_without_come_at_once() -> None:
    odd = Odd(needs("a", "b", "c"))
    assert list(list_references(b"", "d/m.odd", odd)) == ["a", "b", "c"]
    assert list(list_references(b"", "d/m.odd")) == []


def test_urdf_with_substitutions_alone_names_its_meshes() -> None:
    data = URDF.format("$(find p)/a.stl").encode()
    assert list(list_references(data, "r.urdf", Odd())) == ["package://p/a.stl"]


def test_a_foreign_mesh_without_its_bytes_is_refused() -> None:
    with pytest.raises(KernelError) as refused:
        MeshLibrary(AssetStore(), Odd()).load(Mesh("m.odd", "0" * 64))
    assert refused.value.reason is Reason.UNKNOWN_ASSET


@pytest.mark.parametrize(("kind", "most"), MOST_BYTES.items())
def test_a_translation_that_is_too_large_is_not_parsed(kind: str, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 10 bytes in place of millions, which the test would have to make."""
    monkeypatch.setitem(MOST_BYTES, kind, 10)
    for size, reason in ((10, Reason.MALFORMED_FILE), (11, Reason.TOO_LARGE)):
        odd = Odd(lambda data, uri, files, size=size: Translation(kind, b"[" * size))
        with pytest.raises(KernelError) as caught:
            list_references(b"", "a.odd", odd)
        assert caught.value.reason is reason


def test_a_robot_of_too_many_links_is_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(urdf, "MOST_NODES", 3)
    for count in (2, 3):
        links = "".join(f'<link name="{i}"/>' for i in range(count))
        joints = "".join(
            f'<joint name="j{i}" type="fixed"><parent link="0"/><child link="{i}"/></joint>' for i in range(1, count)
        )
        data = f'<robot name="r">{links}{joints}</robot>'.encode()
        if count < 3:
            assert len(imported("r.urdf", uploaded({"r.urdf": data}), MeshLibrary(AssetStore())).nodes) == 3
        else:
            with pytest.raises(KernelError, match=r"r\.urdf: the robot has 3 links; a world has at most 3 nodes"):
                import_model("r.urdf", uploaded({"r.urdf": data}), MeshLibrary(AssetStore()))
