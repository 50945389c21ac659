"""RAPID: modules and data."""

from __future__ import annotations

import re

from virtualrobot_apps.emulators.abb.answers import Item
from virtualrobot_apps.emulators.abb.program import PREDEFINED, Symbol
from virtualrobot_apps.emulators.abb.refused import Refused, unknown
from virtualrobot_apps.emulators.abb.table import Call, resource
from virtualrobot_apps.languages.core.source import Source, decoded
from virtualrobot_apps.languages.rapid.values import value_text

SYMBOL_TYPES = {"per": "pers", "var": "var", "con": "const"}
CLASSES = {"pers": "rap-symproppers", "var": "rap-sympropvar", "const": "rap-sympropconstant"}
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


@resource("POST", "/rw/rapid/tasks/{task}", "loadmod")
def _load(call: Call) -> None:
    """Loads the module of the file `modulepath`; with `replace=true` in place of the one of its name."""
    name = call.needs("modulepath")
    file = call.file(name)
    if not file.is_file():
        raise Refused("FILE_NOT_FOUND", f"there is no file {name!r}")
    replace = _TRUTHS.get(call.form.get("replace", "false").lower())
    if replace is None:
        raise unknown("value of replace", call.form["replace"], tuple(_TRUTHS))
    call.controller.load_module(call.path["task"], Source(decoded(file.read_bytes()), file.name), replace)


@resource("POST", "/rw/rapid/tasks/{task}", "unloadmod")
def _unload(call: Call) -> None:
    """Takes the module `module` out of the task."""
    call.controller.unload_module(call.path["task"], call.needs("module"))


@resource("GET", "/rw/rapid/modules", second="/rw/rapid/tasks/{task}/modules")
def _modules(call: Call) -> list[Item]:
    """The modules of `task`."""
    unit = call.controller.unit(call.name("task"))
    return [
        Item("rap-module-info-li", f"{unit.name}/{name}", {"name": name, "type": "ProgMod"}, f"modules/{name}")
        for name in unit.modules
    ]


@resource("GET", "/rw/rapid/modules/{module}", second="/rw/rapid/tasks/{task}/modules/{module}/text")
def _module(call: Call) -> list[Item]:
    """A module of `task`: its file and its text."""
    unit = call.controller.unit(call.name("task"))
    name = call.path["module"]
    found = next((one for one in unit.modules if one.lower() == name.lower()), None)
    if found is None:
        raise unknown(f"module of {unit.name}", name, list(unit.modules))
    source = unit.modules[found]
    values = {"modname": found, "filename": source.file, "module-length": len(source.text), "module-text": source.text}
    return [Item("rap-module-text", found, values)]


@resource("GET", "/rw/rapid/symbol/data/RAPID/{path*}", second="/rw/rapid/symbol/RAPID/{path*}/data")
def _value(call: Call) -> list[Item]:
    """Value of a datum, TASK/NAME or TASK/MODULE/NAME."""
    path = call.path["path"].split("/")
    one = call.controller.symbol(path)
    return [Item("rap-data", f"RAPID/{'/'.join(path)}", {"value": value_text(one.holder[0])})]


@resource("POST", "/rw/rapid/symbol/data/RAPID/{path*}", "set", second="/rw/rapid/symbol/RAPID/{path*}/data")
def _set_value(call: Call) -> None:
    """Gives a persistent the value `value`; a variable only while nothing runs, a constant never."""
    call.controller.set_symbol(call.path["path"].split("/"), call.needs("value"))


@resource("GET", "/rw/rapid/symbol/properties/RAPID/{path*}", second="/rw/rapid/symbol/RAPID/{path*}/properties")
def _properties(call: Call) -> list[Item]:
    """Storage, type and dimensions of a datum."""
    path = call.path["path"].split("/")
    return [_symbol_item(path[0], call.controller.symbol(path), call.second)]


@resource("POST", "/rw/rapid/symbols", "search-symbols", second="/rw/rapid/symbols/search")
def _search(call: Call) -> list[Item]:
    """The data below `blockurl` (RAPID/TASK/MODULE or less) of `symtyp` (any, per, var, con), `dattyp` and `regexp`."""
    blocks = call.form.get("blockurl", "RAPID").strip("/").split("/")
    if blocks[0] != "RAPID" or len(blocks) > 3:
        raise Refused("INVALIDARG", f"blockurl is RAPID, RAPID/TASK or RAPID/TASK/MODULE, not {'/'.join(blocks)!r}")
    kind, of_type = call.form.get("symtyp", "any"), call.form.get("dattyp", "")
    if kind not in ("any", *SYMBOL_TYPES):
        raise unknown("type of symbols", kind, ("any", *SYMBOL_TYPES))
    try:
        named = re.compile(call.form.get("regexp", "") or ".*", re.IGNORECASE)
    except re.error as error:
        raise Refused("INVALIDARG", f"regexp is no regular expression: {error}") from None
    tasks = [call.controller.unit(blocks[1]).name] if len(blocks) > 1 else list(call.controller.units)
    return [
        _symbol_item(task, one, call.second, "-li")
        for task in tasks
        for one in call.controller.symbols(task)
        if kind in ("any", _kind(one))
        and of_type.lower() in ("", one.type.name)
        and (len(blocks) < 3 or one.module.lower() == blocks[2].lower())
        and named.fullmatch(one.name)
    ]


def _kind(one: Symbol) -> str:
    return next(kind for kind, storage in SYMBOL_TYPES.items() if storage == one.storage)


def _symbol_item(task: str, one: Symbol, second: bool, ending: str = "") -> Item:
    local = one.scope == "local"
    url = f"RAPID/{task}/{f'{one.module}/' if local or one.module == PREDEFINED else ''}{one.name}"
    values = {
        "symburl": url,
        "name": one.name,
        "symtyp": _kind(one),
        "named": "true",
        "dattyp": one.type.name,
        "ndim": one.type.dimensions,
        "dim": " ".join(map(str, _sizes(one.holder[0], one.type.dimensions))),
        "local": str(local).lower(),
        "rdonly": str(one.storage == "const").lower(),
        "taskvar" if one.storage == "var" else "taskpers": str(one.scope == "task").lower(),
    }
    href = f"symbol/{url}/data" if second else f"symbol/data/{url}"
    return Item(f"{CLASSES[one.storage]}{ending}", url, values, href)


def _sizes(value: object, dimensions: int) -> list[int]:
    sizes = []
    while dimensions and isinstance(value, list):
        sizes.append(len(value))
        value, dimensions = value[0], dimensions - 1
    return sizes
