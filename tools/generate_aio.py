"""Write the types of `virtualrobot.aio` for editors and type checkers: `python tools/generate_aio.py [file]`.

What tasks see is made of the library's classes when it is imported; here their functions, with the types of arguments
and answers as the library's text has them, become the stub file beside it.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from types import FunctionType

import virtualrobot
from virtualrobot.aio import faces

ROOT = Path(__file__).resolve().parent.parent
STUB = ROOT / "clients" / "python" / "virtualrobot" / "aio" / "__init__.pyi"

HEAD = '''"""Types of the client library for programs that use asyncio.

Written by tools/generate_aio.py from the library; run it again instead of changing this file.
"""
# ruff: noqa
# pyright: reportIncompatibleMethodOverride=false, reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager

from virtualrobot.aio.faces import Face as Face
from virtualrobot.aio.orders import Order as Order
'''

EDITOR_CREATED = "virtualrobot.scene.adding.Created"
CREATED = {"virtualrobot.scene.scene.Scene": "Node", "virtualrobot.scene.editor.Batch": "str"}
"""Types that editors of the scene return for what they create."""


@cache
def module_names(module: str) -> dict[str, str]:
    """Return what each name that a module imports stands for, as `module.name`, or `module` for a whole one."""
    file = inspect.getsourcefile(sys.modules[module])
    assert file is not None
    names: dict[str, str] = {}
    for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {one.asname or one.name: f"{node.module}.{one.name}" for one in node.names}
        elif isinstance(node, ast.Import):
            names |= {one.asname or one.name: one.name for one in node.names}
        elif isinstance(node, ast.ClassDef):
            names[node.name] = f"{module}.{node.name}"
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {one.id: f"{module}.{one.id}" for one in targets if isinstance(one, ast.Name)}
    return names


class Types(ast.NodeTransformer):
    """Types of one module as the stub writes them; what they name is imported."""

    def __init__(self, kind: type, module: str, imports: dict[str, str]) -> None:
        """Write types of a module in the face of a class, and add to `imports`: what a name of the stub stands for."""
        self._names, self._imports, self._created = module_names(module), imports, CREATED.get(_qualified(kind))

    def text(self, annotation: str) -> str:
        """Return a type as the stub writes it."""
        return ast.unparse(self.visit(ast.parse(annotation, mode="eval")))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Return a name of the stub."""
        return ast.Name(self._named(self._names[node.id])) if node.id in self._names else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Return a name of the stub for one of a module, such as `motion.StartOptions`."""
        if isinstance(node.value, ast.Name) and node.value.id in self._names:
            return ast.Name(self._named(f"{self._names[node.value.id]}.{node.attr}"))
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        """Return a constant; a text is a type that is not known yet."""
        return self.visit(ast.parse(node.value, mode="eval").body) if isinstance(node.value, str) else node

    def _named(self, qualified: str) -> str:
        if qualified == EDITOR_CREATED and self._created is not None:
            return self._created
        if qualified in FACED:
            return FACED[qualified]
        name = qualified.rpartition(".")[2]
        if name in FACED.values() or self._imports.get(name, qualified) != qualified:
            name = qualified.replace(".", "_")
        self._imports[name] = qualified
        return name


def _qualified(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


FACED = {_qualified(kind): faces.name_of(kind) for kind in faces.classes()}
"""Names of the stub by those of the library's classes."""


def kept_attributes(kind: type) -> dict[str, tuple[str, str]]:
    """Return module and type of each attribute that the objects of a class keep, as its `__init__` gives them."""
    found: dict[str, tuple[str, str]] = {}
    for base in reversed(kind.__mro__[:-1]):
        if is_dataclass(base):
            found |= {one.name: (base.__module__, str(one.type)) for one in fields(base) if one.name[0] != "_"}
        elif isinstance(start := vars(base).get("__init__"), FunctionType):
            found |= {name: (base.__module__, text) for name, text in _assigned(inspect.unwrap(start))}
    return found


def _assigned(start: FunctionType) -> Iterator[tuple[str, str]]:
    """Yield the public attributes that an `__init__` sets, each with its type."""
    function = ast.parse(inspect.cleandoc("\n" + inspect.getsource(start))).body[0]
    assert isinstance(function, ast.FunctionDef)
    given = {one.arg: ast.unparse(one.annotation) for one in function.args.args if one.annotation is not None}
    for node in ast.walk(function):
        if isinstance(node, ast.AnnAssign):
            kinds = [(node.target, ast.unparse(node.annotation))]
        elif isinstance(node, ast.Assign):
            kinds = [(target, _kind_of(node.value, given)) for target in node.targets]
        else:
            continue
        yield from ((one.attr, kind) for one, kind in kinds if isinstance(one, ast.Attribute) and one.attr[0] != "_")


def _kind_of(value: ast.expr, given: dict[str, str]) -> str:
    """Return the type of a value: an argument's, or the class that is called."""
    if isinstance(value, ast.Name):
        return given.get(value.id, "object")
    called = ast.unparse(value.func) if isinstance(value, ast.Call) else ""
    return called if called[:1].isupper() else "object"


def _answer(text: str, function: FunctionType, *, kept: bool) -> str:
    """Return the type of what a function of a face returns, for one of the library that returns `text`."""
    if kept:
        return text
    if not text.startswith("Iterator["):
        return f"Order[{text}]"
    told = text.removeprefix("Iterator[").removesuffix("]")
    if "contextlib" in (inspect.unwrap(function, stop=_is_block).__code__.co_filename):
        return f"AbstractAsyncContextManager[{told}]"
    return f"AsyncIterator[{told}]"


def _is_block(function: object) -> bool:
    return isinstance(function, FunctionType) and "contextlib" in function.__code__.co_filename


def _summary(one: object) -> str:
    return (inspect.getdoc(one) or "").split("\n\n")[0].replace("\n", " ").replace('"""', "'''")


def _function(kind: type, name: str, function: FunctionType, imports: dict[str, str]) -> Iterator[str]:
    plain = inspect.unwrap(function)
    types = Types(kind, plain.__module__, imports)
    signature = inspect.signature(plain)
    parameters = []
    for one in signature.parameters.values():
        annotation = inspect.Parameter.empty if one.name == "self" else types.text(str(one.annotation))
        default = one.default if one.default is inspect.Parameter.empty else ...
        parameters.append(one.replace(annotation=annotation, default=default))
    text = str(inspect.Signature(parameters)).replace("'", "").replace("Ellipsis", "...")
    kept = faces.is_kept(kind, name)
    answer = _answer(types.text(str(signature.return_annotation)), function, kept=kept)
    yield f"    def {name}{text} -> {answer}:"
    yield f'        """{_summary(function)}"""'


def _property(kind: type, name: str, own: property, imports: dict[str, str]) -> Iterator[str]:
    assert isinstance(own.fget, FunctionType)
    types = Types(kind, own.fget.__module__, imports)
    text = types.text(str(inspect.signature(own.fget).return_annotation))
    yield "    @property"
    yield f"    def {name}(self) -> {text if faces.is_kept(kind, name) else f'Order[{text}]'}:"
    yield f'        """{_summary(own)}"""'
    if own.fset is not None and f"set_{name}" not in faces.own_members(kind):
        setter = inspect.unwrap(own.fset)
        given = list(inspect.signature(setter).parameters.values())[1]
        text = Types(kind, setter.__module__, imports).text(str(given.annotation))
        yield f"    def set_{name}(self, value: {text}) -> Order[None]:"
        yield f'        """Set `{name}`: {_summary(own)}"""'


def _class(kind: type, imports: dict[str, str]) -> Iterator[str]:
    name = FACED[_qualified(kind)]
    yield f"\nclass {name}(Face):"
    yield f'    """{_summary(kind)}"""'
    members = faces.own_members(kind)
    for attribute, (module, text) in kept_attributes(kind).items():
        if attribute not in members and attribute not in faces.LEFT_OUT:
            yield f"    {attribute}: {Types(kind, module, imports).text(text)}"
    for own, member in members.items():
        if isinstance(member, FunctionType):
            yield from _function(kind, own, member, imports)
        else:
            yield from _property(kind, own, member, imports)
    if hasattr(kind, "__enter__"):
        yield f"    async def __aenter__(self) -> {name}: ..."
    told = getattr(kind, "__next__", None) or getattr(kind, "__iter__", None)
    if told is not None:
        function = inspect.unwrap(told)
        text = Types(kind, function.__module__, imports).text(str(inspect.signature(function).return_annotation))
        one = text.removeprefix("Iterator[").removesuffix("]")
        yield f"    def __aiter__(self) -> {name}: ..."
        yield f"    async def __anext__(self) -> {one}: ..."


def stub() -> str:
    """Return the stub file."""
    imports: dict[str, str] = {}
    body = [line for kind in faces.classes() for line in _class(kind, imports)]
    connect = _function(virtualrobot.Client, "connect", virtualrobot.connect, imports)  # pyright: ignore[reportArgumentType] a function
    body += ["", *(line.removeprefix("    ") for line in connect)]
    lines = []
    for name, qualified in sorted(imports.items(), key=lambda one: (one[1], one[0])):
        module, _, own = qualified.rpartition(".")
        lines.append(f"from {module} import {own} as {name}" if module else f"import {own} as {name}")
    return HEAD + "\n".join([*lines, *body]) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1] if len(sys.argv) > 1 else STUB).write_text(stub(), encoding="utf-8", newline="\n")
