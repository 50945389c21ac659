"""The xacro importer expands what xacro does, and gets every file from its caller."""

from __future__ import annotations

import builtins
import gc
import math
import weakref
import xml.dom.minidom
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import xacro
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types
from virtualrobot_plugins.importers.xacro import Xacro, XacroSettings
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation
from xacro import substitution_args

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def robot(*lines: str) -> str:
    return "\n".join([HEAD, *lines, "</robot>"])


def translate(
    text: str, files: Mapping[str, str | None] | None = None, uri: str = "/m/urdf/r.xacro", **arguments: str
) -> Translation:
    """Expand a text; what it asks for comes from `files`."""
    known: dict[str, bytes | None] = {}
    while True:
        try:
            return Xacro(XacroSettings(arguments)).translate(text.encode(), uri, known)
        except FilesNeeded as needed:
            assert not known.keys() & set(needed.names), "asked twice"
            for name in needed.names:
                content = (files or {})[name]
                known[name] = None if content is None else content.encode()


def links(text: str, files: Mapping[str, str | None] | None = None, **options: str) -> list[str]:
    """Return the names of the links that a text expands to."""
    root = etree.fromstring(translate(text, files, **options).data)
    return [link.get("name") for link in root.findall("link")]


def refusal(text: str, files: Mapping[str, str | None] | None = None, **options: str) -> ArgumentError:
    with pytest.raises(ArgumentError) as refused:
        translate(text, files, **options)
    return refused.value


def asked(text: str, uri: str) -> tuple[str, ...]:
    with pytest.raises(FilesNeeded) as needed:
        Xacro(XacroSettings()).translate(text.encode(), uri, {})
    return needed.value.names


def test_macros_properties_conditions_and_expressions() -> None:
    text = robot(
        '<xacro:property name="count" value="${1 + 2}"/>',
        '<xacro:macro name="leg" params="name angle:=${pi/2} *block">'
        '<link name="leg_${name}"><a angle="${angle}"/><xacro:insert_block name="block"/></link></xacro:macro>',
        '<xacro:leg name="${count}"><inner/></xacro:leg>',
        '<xacro:if value="${count == 3}"><link name="three"/></xacro:if>',
        '<xacro:unless value="${count == 3}"><link name="other"/></xacro:unless>',
    )
    root = etree.fromstring(translate(text).data)
    assert [link.get("name") for link in root.findall("link")] == ["leg_3", "three"]
    assert float(root.find("link/a").get("angle")) == math.pi / 2
    assert root.find("link/inner") is not None


@pytest.mark.parametrize(
    ("uri", "name", "joined"),
    [
        ("/m/urdf/r.xacro", "a/x.xacro", "/m/urdf/a/x.xacro"),
        ("/m/urdf/r.xacro", "../x.xacro", "/m/x.xacro"),
        ("package://p/urdf/r.xacro", "x.xacro", "package://p/urdf/x.xacro"),
        ("r.xacro", "x.xacro", "x.xacro"),
        ("C:\\m\\r.xacro", "x.xacro", "C:/m/x.xacro"),
        ("/m/r.xacro", "/n/x.xacro", "/n/x.xacro"),
        ("/m/r.xacro", "$(find p)/urdf/x.xacro", "package://p/urdf/x.xacro"),
        ("/m/r.xacro", "$(dirname)/y/x.xacro", "/m/y/x.xacro"),
        ("/m/r.xacro", "$(cwd)/y/x.xacro", "/m/y/x.xacro"),
    ],
)
def test_an_include_is_asked_for_by_its_joined_name(uri: str, name: str, joined: str) -> None:
    assert asked(robot(f'<xacro:include filename="{name}"/>'), uri) == (joined,)


def test_an_include_counts_from_the_file_that_includes_and_so_does_what_comes_after_it() -> None:
    files = {
        "package://p/urdf/a.xacro": robot(
            '<xacro:include filename="../macros/b.xacro"/>', '<xacro:include filename="$(dirname)/d.xacro"/>'
        ),
        "package://p/macros/b.xacro": robot('<xacro:property name="b" value="bee"/>'),
        "package://p/urdf/d.xacro": robot('<link name="dee"/>'),
        "/m/urdf/c.xacro": robot('<link name="${b}"/>'),
    }
    text = robot('<xacro:include filename="$(find p)/urdf/a.xacro"/>', '<xacro:include filename="c.xacro"/>')
    assert links(text, files) == ["dee", "bee"]


def test_yaml_is_loaded_with_units_from_what_the_caller_gives() -> None:
    files = {"package://p/config/limits.yaml": "shoulder:\n  upper: !degrees 90\nnames: [a, b]\n"}
    text = robot(
        '<xacro:property name="data" value="${xacro.load_yaml(\'$(find p)/config/limits.yaml\')}"/>',
        '<link name="${data.names[1]}" upper="${data.shoulder.upper}"/>',
    )
    root = etree.fromstring(translate(text, files).data)
    assert root.find("link").get("name") == "b"
    assert float(root.find("link").get("upper")) == math.pi / 2


def test_arguments_have_their_defaults_unless_given() -> None:
    text = robot('<xacro:arg name="prefix" default="left_"/>', '<link name="$(arg prefix)arm"/>')
    assert links(text) == ["left_arm"]
    assert links(text, prefix="right_") == ["right_arm"]
    assert links(text) == ["left_arm"]  # nothing stays from the call before


def test_an_argument_that_the_file_lacks_is_a_warning_with_the_nearest() -> None:
    text = robot('<xacro:arg name="prefix" default=""/>', '<link name="$(arg prefix)arm"/>')
    assert translate(text, perfix="a_").warnings == (
        "r.xacro: the file has no argument 'perfix'; did you mean 'prefix'?",
    )
    assert translate(text, prefix="a_").warnings == ()


def test_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VR_SIDE", "left")
    monkeypatch.delenv("VR_OTHER", raising=False)
    assert links(robot('<link name="$(env VR_SIDE)_$(optenv VR_OTHER a b)_$(optenv VR_SIDE x)"/>')) == ["left_a b_left"]
    assert "VR_OTHER" in str(refusal(robot('<link name="$(env VR_OTHER)"/>')))


def test_the_documents_names_of_packages_stay_for_the_kernels_resolver() -> None:
    text = robot(
        '<mesh filename="file://$(find p)/meshes/a.stl"/>',
        '<mesh filename="package://q/b.stl"/>',
        '<mesh filename="$(find p)/c.stl"/>',
    )
    root = etree.fromstring(translate(text).data)
    names = [mesh.get("filename") for mesh in root.findall("mesh")]
    assert names == ["package://p/meshes/a.stl", "package://q/b.stl", "package://p/c.stl"]


def test_words_without_their_prefix_are_read_as_files_from_before_ros_jade_have_them() -> None:
    macro = '<macro name="m"><link name="${n}"/></macro>'
    files = {"/m/urdf/m.xacro": robot('<property name="n" value="old"/>', macro)}
    text = robot('<include filename="m.xacro"/>', "<xacro:m/>")
    assert links(text, files) == ["old"]
    assert any("<property> without the prefix xacro:" in warning for warning in translate(text, files).warnings)


def test_an_optional_include_may_be_nowhere_and_another_may_not() -> None:
    text = robot('<xacro:include filename="x.xacro" {}/>', '<link name="a"/>')
    assert links(text.format('optional="true"'), {"/m/urdf/x.xacro": None}) == ["a"]
    error = refusal(text.format(""), {"/m/urdf/x.xacro": None})
    assert str(error) == "r.xacro: '/m/urdf/x.xacro' is nowhere"
    assert error.metadata["missing"] == "/m/urdf/x.xacro"


ERRORS: dict[str, tuple[str, dict[str, str | None], str]] = {
    "not XML": (f"{HEAD}\n<link>\n</robot>", {}, "r.xacro:3: not XML: "),
    "included not XML": (
        robot('<xacro:include filename="x.xacro"/>'),
        {"/m/urdf/x.xacro": f"{HEAD}\n\n<"},
        "x.xacro:3: not XML: ",
    ),
    "unknown macro": (robot("<xacro:lgg/>"), {}, "r.xacro: unknown macro name: xacro:lgg"),
    "unknown property": (robot('<link name="${nmae}"/>'), {}, "name 'nmae' is not defined"),
    "in a macro of an included file": (
        robot('<xacro:include filename="x.xacro"/>'),
        {"/m/urdf/x.xacro": robot('<xacro:macro name="m" params="a">${b}</xacro:macro>', '<xacro:m a="1"/>')},
        "x.xacro, included by r.xacro: in macro m: name 'b' is not defined",
    ),
    "a parameter is missing": (
        robot('<xacro:macro name="m" params="a"/>', "<xacro:m/>"),
        {},
        "in macro m: Undefined parameters [a]",
    ),
    "undeclared argument": (robot('<link name="$(arg a)"/>'), {}, "$(arg a): no argument of that name is declared"),
    "unknown substitution": (robot('<link name="$(anon a)"/>'), {}, "Unknown substitution command [anon a]"),
    "wildcards": (robot('<xacro:include filename="*.xacro"/>'), {}, "has wildcards: name the files one by one"),
    "circle": (robot('<xacro:property name="a" value="${a}"/>', '<link name="${a}"/>'), {}, "circular variable"),
    "file's own words": (robot('${xacro.fatal("no arm chosen")}'), {}, "no arm chosen"),
    "a hidden name": (robot('<link name="${().__class__}"/>'), {}, "Use of invalid name(s)"),
    "opening a file": (robot("<link name=\"${open('/etc/passwd')}\"/>"), {}, "name 'open' is not defined"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_refused_with_file_and_place(case: str) -> None:
    text, files, message = ERRORS[case]
    assert message in str(refusal(text, files))


def test_warnings_of_the_file_and_the_library_are_kept() -> None:
    text = robot('<xacro:property name="pi" value="3"/>', "<a>${xacro.warning('look here')}</a>")
    warnings = translate(text).warnings
    assert "r.xacro: redefining global symbol: pi" in warnings
    assert "r.xacro: look here" in warnings


def test_nothing_touches_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("the disk was read")

    files = {"/m/urdf/x.xacro": robot('<link name="a"/>'), "/m/urdf/y.yaml": "b: 1"}
    text = robot('<xacro:include filename="x.xacro"/>', "<c d=\"${xacro.load_yaml('y.yaml').b}\"/>")
    expected = translate(text, files)
    monkeypatch.setattr(builtins, "open", refuse)
    monkeypatch.setattr("os.listdir", refuse)
    monkeypatch.setattr("os.scandir", refuse)
    assert translate(text, files) == expected


@pytest.mark.parametrize("act", [lambda: translate(robot('<link name="a"/>')), lambda: refusal(robot("<xacro:no/>"))])
def test_the_library_is_as_it_was_afterwards(act: Callable[[], object], tmp_path: Path) -> None:
    def state() -> dict[str, object]:
        return {**vars(xacro), **{f"args.{name}": value for name, value in vars(substitution_args).items()}}

    before = state()
    act()
    after = state()
    assert before.keys() == after.keys()
    assert [name for name in before if before[name] is not after[name]] == []
    (tmp_path / "plain.xacro").write_text(robot('<link name="plain"/>'))
    document: Any = xacro.process_file(str(tmp_path / "plain.xacro"))
    assert "plain" in document.toxml()


def test_no_document_stays_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    documents: list[weakref.ref[object]] = []
    parse = xml.dom.minidom.parseString

    def noted(data: bytes) -> xml.dom.minidom.Document:
        document = parse(data)
        documents.append(weakref.ref(document))
        return document

    monkeypatch.setattr(xml.dom.minidom, "parseString", noted)
    for _ in range(3):
        translate(robot("<!-- of a -->", '<xacro:if value="1">', '<link name="a"/>', "</xacro:if>", "<b/>"))
    gc.collect()
    assert len(documents) == 3 and all(document() is None for document in documents)


def test_errors_inside_expressions_do_not_hide_the_request_for_a_file() -> None:
    assert asked(robot("<a b=\"${xacro.load_yaml('c.yaml')['d']}\"/>"), "/m/r.xacro") == ("/m/c.yaml",)
