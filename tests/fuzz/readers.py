"""Readers of files as functions of bytes, and files to begin with: what a hunt damages and `make test` replays."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
from PIL import Image
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats import program_file
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import File, Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.formats.references import list_references
from virtualrobot_kernel.formats.srdf import read_srdf
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.scenes.reading import read_scene
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.commands import ClearWorld, CreateNodes
from virtualrobot_kernel.world.state import empty_state
from virtualrobot_kernel.world.structure import NodeSpec
from virtualrobot_plugins.importers.dxf.importer import DxfImporter, DxfSettings
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.step import StepImporter, StepSettings
from virtualrobot_plugins.importers.threemf import ThreeMfImporter
from virtualrobot_plugins.importers.vrml.importer import VrmlImporter
from virtualrobot_plugins.importers.xacro import Xacro, XacroSettings
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Importer

from tests.pybullet_models import MODELS

ROOT = Path(__file__).resolve().parents[2]
FOREIGN = ROOT / "tests/unit/plugins/importers/files"
TEXTS = ("docs/*.md", "tests/unit/formats/*.py", "tests/unit/plugins/importers/**/*.py", "tests/unit/scenes/*.py")
"""Where small files stand as texts, in fenced blocks and in strings."""

MOST_SEED_BYTES = 40_000
"""Greatest size of a file to begin with: of larger ones few damages tell anything, and each takes long."""

REFUSED = (ArgumentError, FilesNeeded)
"""Exceptions of importers that say what is wrong with a file, or what they need besides."""


@dataclass(frozen=True, slots=True)
class Reader:
    """Reader of one format: a function of bytes that returns, or raises a refusal, and the files to begin with."""

    read: Callable[[bytes], object]
    seeds: Callable[[], list[bytes]]
    cost: int = 1
    """Cost of a file, of that of others: where each starts a process, fewer are read."""


def refused(read: Callable[[bytes], object], data: bytes) -> bool:
    """Return whether bytes are refused in words; whatever else is raised is a fault and goes on."""
    try:
        read(data)
    except KernelError as error:
        if error.reason in (Reason.INTERNAL, Reason.PLUGIN_FAILED):
            raise
        assert str(error), "a refusal without a word"
        return True
    except REFUSED:
        return True
    return False


def _made(nodes: tuple[NodeSpec, ...]) -> None:
    """Put nodes that were read into an empty world: it takes or refuses them."""
    state = empty_state()
    apply(index.empty(), state, (CreateNodes(nodes),), world_poses)


def _uploaded(name: str, data: bytes) -> tuple[Files, MeshLibrary]:
    """Return a file as a client uploads it, with a texture and a mesh beside it, and nothing of the disk."""
    store = AssetStore()
    beside = {**_beside(), name: data}
    return Files(store, {one: store.put(content) for one, content in beside.items()}), MeshLibrary(store)


@cache
def _beside() -> Mapping[str, bytes]:
    """Return the files that files to begin with name."""
    return {
        "t.png": _picture("PNG"),
        "m.mtl": b"newmtl a\nKd 1 0 0\nd 0.5\nmap_Kd t.png\n",
        "b.bin": bytes(range(256)),
        "cube.stl": _stl(),
        "arm.urdf": bare_arm(),
    }


@cache
def bare_arm() -> bytes:
    """Return a robot with a gripper and without meshes."""
    text = (MODELS / "franka_panda/panda.urdf").read_bytes()
    return re.sub(rb"<(visual|collision)>.*?</\1>", b"", text, flags=re.DOTALL)


def _picture(kind: str) -> bytes:
    from io import BytesIO

    out = BytesIO()
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)).save(out, kind)
    return out.getvalue()


def _stl() -> bytes:
    corner = np.array([((0, 0, 1), (0, 0, 0), (1, 0, 0), (0, 1, 0))], np.float32)
    return bytes(80) + (1).to_bytes(4, "little") + corner.tobytes() + bytes(2)


def _model(name: str, data: bytes) -> None:
    files, library = _uploaded(name, data)
    list_references(data, name)
    model = import_model(name, files, library)
    assert isinstance(model, ImportedModel)
    _made(model.nodes)


def _texture(data: bytes) -> None:
    """Read a mesh whose texture this is."""
    obj = b"mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    files, library = _uploaded("t.png", data)
    store = library.store
    named = {**files.uploaded, "o.obj": store.put(obj)}
    model = import_model("o.obj", Files(store, named), library)
    assert isinstance(model, ImportedModel)


def start_scene(folder: Path) -> str:
    """Return a scene file with a node of each kind, whose model and mesh are written into a folder."""
    text = SCENE.decode()
    for name in ("arm.urdf", "cube.stl"):
        (folder / name).write_bytes(_beside()[name])
        text = text.replace(name, str(folder / name))
    return text


def _scene(data: bytes) -> None:
    files, library = _uploaded("s.yaml", data)
    text = data.decode(errors="replace")
    commands, _, _ = read_scene(text, "s.yaml", files, library)
    state = empty_state()
    assert isinstance(commands[0], ClearWorld)
    apply(index.empty(), state, commands, world_poses)


def _srdf(data: bytes) -> None:
    read_srdf(File("r.srdf", data, ""), _arm(), "r")


@cache
def _arm() -> tuple[NodeSpec, ...]:
    files, library = _uploaded("r.urdf", bare_arm())
    model = import_model("r.urdf", files, library)
    assert isinstance(model, ImportedModel)
    return model.nodes


def _foreign(importer: Importer, name: str, data: bytes) -> None:
    """Translate, with whatever the file asks for nowhere; the kernel reads what comes of it."""
    files: dict[str, bytes | None] = {}
    for _ in range(5):
        try:
            translation = importer.translate(data, name, files)
            break
        except FilesNeeded as needed:
            files.update(dict.fromkeys(needed.names, None))
    else:
        return
    if translation.format == ".yaml":
        _scene(translation.data)
    else:
        _model(f"m{translation.format}", translation.data)


def _journalled(data: bytes) -> None:
    """Decode what a journal holds; what is read is written and read again as the same."""
    codec = world_codec()
    value = codec.decode(data)
    assert not (where := same(value, codec.decode(codec.encode(value)))), where


def _documents() -> list[bytes]:
    """Return commands of a scene, and the world that they make, as a journal holds them."""
    files, library = _uploaded("s.yaml", SCENE)
    commands, _, _ = read_scene(SCENE.decode(), "s.yaml", files, library)
    state = empty_state()
    world = apply(index.empty(), state, commands, world_poses)
    codec = world_codec()
    return [*map(codec.encode, commands), codec.encode(image_of(world.structure, world.state))]


def _on_disk(*patterns: str, root: Path = MODELS) -> list[bytes]:
    found = [path for pattern in patterns for path in sorted(root.glob(pattern)) if path.is_file()]
    return [path.read_bytes() for path in found if path.stat().st_size <= MOST_SEED_BYTES]


@cache
def _written() -> str:
    return "\n".join(path.read_text() for pattern in TEXTS for path in sorted(ROOT.glob(pattern)))


def _texts(pattern: str) -> list[bytes]:
    """Return what matches in the docs and tests."""
    return list(dict.fromkeys(match[0].encode() for match in re.finditer(pattern, _written(), re.DOTALL)))


def _complete(seeds: list[bytes]) -> list[bytes]:
    """Return files that name the one mesh that is there, whatever they named, so that reading goes on past it."""
    named = re.compile(
        rb"(?<=filename=\")[^\"]+\.(?:stl|obj|dae|STL)(?=\")|(?<=<uri>)[^<]+\.(?:stl|obj|dae|STL)(?=</uri>)"
    )
    return [named.sub(b"cube.stl", seed) for seed in seeds]


def _with_arm(seeds: list[bytes]) -> list[bytes]:
    """Return scenes whose models are the one that is there, and one with a node of each kind."""
    for old, new in (
        (rb"(?<=[ {]uri: )[^\s,}]+", b"arm.urdf"),
        (rb"mount_on: *[^\s,}]+", b"strict: true"),
        (rb"positions: \[.*?\]", b"speed_factor: 0.5"),
    ):
        seeds = [re.sub(old, new, seed) for seed in seeds]
    names = ((b"lbr_iiwa_link_", b"panda_link"), (b"conveyor.belt", b"conveyor.panda_link1"))
    for old, new in names:
        seeds = [seed.replace(old, new) for seed in seeds]
    return [*seeds, SCENE]


def _elements(tag: str) -> list[bytes]:
    return [one for one in _texts(rf"<{tag}[ >].*?</{tag}>") if len(one) <= MOST_SEED_BYTES]


def _yaml_of(paths: str, key: str, other: str = "") -> list[bytes]:
    """Return our YAML files and blocks of pages that say `key`, but for those of another kind, which say `other`."""
    blocks = [match[1].encode() for match in re.finditer(r"```yaml\n(.*?)```", _written(), re.DOTALL)]
    files = [path.read_bytes() for path in sorted(ROOT.glob(paths))]
    said = [one for one in (*files, *blocks) if key.encode() in one and b"schema_version" in one]
    return [one for one in said if not other or other.encode() not in one]


def _glb() -> list[bytes]:
    """Return glTF files of one triangle, with buffers inside and beside them, and the same as GLB."""
    import trimesh

    box = trimesh.creation.box((1, 2, 3))
    glb = bytes(trimesh.Scene(box).export(file_type="glb"))  # pyright: ignore[reportArgumentType]
    return [glb]


def _gltf() -> list[bytes]:
    import base64

    data = base64.b64encode(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32).tobytes()).decode()
    one = (
        '{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[0,0,1]}],'
        '"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],'
        '"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"baseColorTexture":{"index":0}}}],'
        '"textures":[{"source":0}],"images":[{"uri":"t.png"}],'
        '"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},'
        '{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],'
        '"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":1,"byteLength":24}],'
        f'"buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{data}"}},'
        '{"byteLength":256,"uri":"b.bin"}]}'
    )
    return [one.encode()]


def _off_and_ply(ending: str) -> list[bytes]:
    import trimesh

    box = trimesh.creation.box((1, 2, 3))
    return [one if isinstance(one := box.export(file_type=ending), bytes) else str(one).encode()]


def _xacro() -> list[bytes]:
    """Return robots with macros, arguments and conditions; none that multiply.

    A file of a few lines can ask for a day (`9**9**9`) or all memory: a kernel ends the process that reads it.
    """
    return [
        *(one for one in _elements("robot") if b"xacro" in one and b"**" not in one),
        XACRO,
        XACRO.replace(b"</robot>", INCLUDE),
    ]


INCLUDE = b'<xacro:include filename="more.xacro" ns="n"/></robot>'
XACRO = b"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="prefix" default="a"/><xacro:property name="size" value="0.5"/>
<xacro:property name="sizes" value="${dict(x=1, y=[1, 2])}"/>
<xacro:macro name="limb" params="name parent:=^|base size:=${size} *origin **more">
<link name="${name}"><visual><geometry><box size="${size} ${sizes['x']} ${sizes['y'][0]}"/></geometry></visual></link>
<joint name="${name}_joint" type="revolute"><parent link="${parent}"/><child link="${name}"/>
<xacro:insert_block name="origin"/><xacro:insert_block name="more"/>
<limit lower="${-pi/2}" upper="${radians(90)}" velocity="1" effort="1"/></joint></xacro:macro>
<link name="base"/>
<xacro:limb name="$(arg prefix)_one"><origin xyz="0 0 ${sin(0.5)}"/><more><axis xyz="0 0 1"/></more></xacro:limb>
<xacro:if value="${size > 0.1}"><link name="b"/>
<joint name="f" type="fixed"><parent link="base"/><child link="b"/></joint></xacro:if>
<xacro:unless value="false"><material name="m"><color rgba="1 0 0 1"/></material></xacro:unless></robot>
"""

SCENE = b"""schema_version: 1
speed_factor: 0.5
nodes:
- name: table
  hidden: true
  figures: [{box: {size: {x: 1, y: 2, z: 0.1}}, material: {color: {red: 1, alpha: 0.5}}}]
  object: {}
- name: ball
  parent: table
  parent_t_node: {position: {x: 0.1}, orientation: {w: 1}}
  figures: [{sphere: {radius_meters: 0.1}}]
  part: {mass_kilograms: 1}
- {name: r, robot: {postures: [{name: home, joint_positions: {j: 0.5}}], groups: [{name: g, joint_names: [j]}]}}
- name: r.a
  parent: r
  link: {joint: {type: JOINT_TYPE_FIXED}, inertial: {mass_kilograms: 2, diagonal: {x: 1, y: 1, z: 1}}}
- name: r.b
  parent: r.a
  link:
    joint:
      name: j
      type: JOINT_TYPE_REVOLUTE
      axis: {z: 1}
      limits: {lower: -1, upper: 1, velocity: 1, acceleration: 1, jerk: 1}
- {name: r.c, parent: r.b, link: {joint: {name: k, type: JOINT_TYPE_PRISMATIC, axis: {x: 1}, mimic: {joint: j}}}}
- name: hand
  parent: r.b
  tool: {states: [{name: open, joint_positions: {j: 0.1}}], tool_center_points: [{name: tcp}]}
- {name: goal, target: {robot: r, joint_positions: {j: 0.3}}}
- name: note
  figures: [{mesh: {uri: cube.stl, scale: {x: 1, y: -1, z: 2}}}, {cylinder: {radius_meters: 1, length_meters: 2}}]
  annotation: {}
- {name: scanner, parent: r.c, range_sensor: {}}
- {name: camera, parent: r.c, camera_sensor: {}}
- {name: touch, parent: r.c, contact_sensor: {}}
- {name: lamp, light: {}}
models:
- {name: arm, uri: arm.urdf, parent: table, base_joint: JOINT_TYPE_FLOATING}
- name: dh
  denavit_hartenberg:
    convention: DENAVIT_HARTENBERG_CONVENTION_STANDARD
    rows: [{d_meters: 0.1, a_meters: 0.2, alpha_radians: 1.57}]
signals:
- {name: s, value: {boolean: true}}
robot_states:
- {name: r, positions: [0.5], tool: hand, tool_center_point: tcp, tool_states: {hand: open}, speed_factor: 0.3}
allowed_pairs:
- {first: table, second: ball, reason: stands}
collision_settings: {look_ahead_seconds: 0.1}
"""

OBJ = (
    b"mtllib m.mtl\no thing\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
    b"usemtl a\ns 1\nf 1/1/1 2/2/1 3/3/1\nf -1 -2 -3\nl 1 2\np 1\n"
)
STL_TEXT = (
    b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid"
)


def _foreign_reader(importer: Importer, name: str, seeds: Callable[[], list[bytes]]) -> Reader:
    return Reader(partial(_foreign, importer, name), seeds)


READERS: Mapping[str, Reader] = {
    "urdf": Reader(
        partial(_model, "r.urdf"), lambda: _complete([*_elements("robot"), *_on_disk("*.urdf", "*/*.urdf")])
    ),
    "srdf": Reader(_srdf, lambda: [(ROOT / "tests/unit/formats/panda.srdf").read_bytes(), *_elements("robot")]),
    "scene": Reader(_scene, lambda: _with_arm(_yaml_of("clients/python/virtualrobot_apps/**/cell.yaml", "nodes"))),
    "program": Reader(
        lambda data: program_file.parse(data.decode(errors="replace")),
        lambda: _yaml_of("clients/python/virtualrobot_apps/**/program.yaml", "steps", other="follow:"),
    ),
    "journal": Reader(_journalled, _documents),
    "stl": Reader(partial(_model, "m.stl"), lambda: [_stl(), STL_TEXT]),
    "obj": Reader(partial(_model, "m.obj"), lambda: [OBJ, *_on_disk("*.obj")]),
    "dae": Reader(
        partial(_model, "m.dae"), lambda: [*_elements("COLLADA"), *_on_disk("*.dae", "*/*.dae", "*/*/*.dae")]
    ),
    "gltf": Reader(partial(_model, "m.gltf"), _gltf),
    "glb": Reader(partial(_model, "m.glb"), _glb),
    "texture": Reader(_texture, lambda: [_picture(kind) for kind in ("PNG", "JPEG", "BMP", "GIF", "TIFF", "PPM")]),
    "sdf": _foreign_reader(
        SdfImporter(), "m.sdf", lambda: _complete([*_elements("sdf"), *_on_disk("*.sdf", "*/*.sdf")])
    ),
    "dxf": _foreign_reader(DxfImporter(DxfSettings()), "m.dxf", lambda: _on_disk("*.dxf", "*.DXF", root=FOREIGN)),
    "ply": _foreign_reader(PlyImporter(), "m.ply", lambda: _off_and_ply("ply")),
    "off": _foreign_reader(OffImporter(), "m.off", lambda: _off_and_ply("off")),
    "vrml": _foreign_reader(
        VrmlImporter(),
        "m.wrl",
        lambda: [*_on_disk("*.wrl", root=FOREIGN), *_texts(r"#VRML V2.0 utf8.*?(?=\"\"\"|```)")],
    ),
    "threemf": _foreign_reader(ThreeMfImporter(), "m.3mf", lambda: _on_disk("*.3mf", root=FOREIGN)),
    "step": Reader(
        partial(_foreign, StepImporter(StepSettings()), "m.step"), lambda: _on_disk("*.step", root=FOREIGN), cost=50
    ),
    "xacro": _foreign_reader(Xacro(XacroSettings({})), "r.xacro", _xacro),
}
"""Readers by the name of their format. In a kernel each importer has a process of its own, with a deadline."""
