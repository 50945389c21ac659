"""The reference of plugins says what the code says: hooks, interfaces, values, faults and laws."""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from virtualrobot_kernel.components.catalog import LOOK_SECONDS
from virtualrobot_kernel.components.running import START_SECONDS
from virtualrobot_sdk import (
    drivers,
    errors,
    hookspecs,
    importers,
    kinematics,
    mobile,
    models,
    physics,
    rays,
    registration,
    selfcheck,
    testing,
    vehicles,
)
from virtualrobot_sdk.drivers import driver
from virtualrobot_sdk.hookspecs import HOOKS, MODELS_HOOK
from virtualrobot_sdk.testing.contract import KinematicsContract
from virtualrobot_sdk.testing.examination import LAWS
from virtualrobot_sdk.testing.subject import LOADING_SECONDS
from virtualrobot_sdk.worker.parent import MEMORY_GROWTH_BYTES

TEXT = (Path(__file__).resolve().parent.parent / "docs" / "plugins.md").read_text("utf-8")
SDK = Path(inspect.getfile(registration)).parent
INTERFACES = (
    kinematics.Kinematics,
    mobile.MobileKinematics,
    physics.PhysicsEngine,
    vehicles.VehicleDynamics,
    rays.RayCaster,
    rays.SensorModel,
    drivers.Driver,
    importers.Importer,
)


def signature(function: object) -> str:
    """Return `name(argument: type) -> type` of a method or function."""
    assert inspect.isfunction(function)
    takes = inspect.signature(function)
    others = [parameter for parameter in takes.parameters.values() if parameter.name != "self"]
    shown = str(takes.replace(parameters=others)).replace("'", "").replace("Ellipsis", "...")
    return function.__name__ + shown


def section(title: str) -> str:
    """Return the text below a second-level heading."""
    return TEXT.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


def rows(text: str) -> dict[str, str]:
    """Return what tables say, by the first cell."""
    return {name: rest for name, rest in re.findall(r"^\| `(\w+)`[^|]*\|(.*)\|$", text, re.MULTILINE)}


def members(interface: type) -> list[str]:
    return [name for name in vars(interface) if not name.startswith("_")]


def values(module: ModuleType) -> dict[str, list[str]]:
    """Return the fields of the values that a module defines, by class."""
    found = {}
    for name, one in vars(module).items():
        if inspect.isclass(one) and one.__module__ == module.__name__:
            if dataclasses.is_dataclass(one):
                found[name] = [field.name for field in dataclasses.fields(one)]
            elif issubclass(one, tuple):
                found[name] = list(one.__annotations__)
    return found


def test_every_hook_is_told_as_it_is() -> None:
    hooks = {name: f for name, f in vars(hookspecs).items() if name.startswith("virtualrobot_register")}
    told = dict(re.findall(r"^\| `(\w+)\((?:register)\)` \|(.*)\|$", section("Hooks"), re.MULTILINE))
    assert f"`{MODELS_HOOK}(register)`" in section("Models by name")
    assert {*told, MODELS_HOOK} == set(hooks) == {hook.hook for hook in HOOKS.values()} | {MODELS_HOOK}
    for hook in HOOKS.values():
        assert list(inspect.signature(hooks[hook.hook]).parameters) == ["register"]
        factory, returned, seconds = (cell.strip() for cell in told[hook.hook].split("|"))
        assert factory == f"`factory({', '.join((*hook.arguments, 'settings'))})`"
        assert float(seconds) == hook.deadline_seconds
        (interface,) = re.findall(r"`(\w+)`", returned)
        assert f".{interface}`" in (hooks[hook.hook].__doc__ or "")


@pytest.mark.parametrize("protocol", [hookspecs.Register, hookspecs.RegisterImporter])
def test_register_is_told_as_it_is(protocol: type) -> None:
    takes = inspect.signature(protocol.__call__)
    bare = [p.replace(annotation=inspect.Parameter.empty) for p in takes.parameters.values() if p.name != "self"]
    shown = str(inspect.Signature(bare))
    shown = re.sub(r"=<Isolation\.(\w+): '\w+'>", r"=Isolation.\1", shown)
    assert f"\nregister{shown}\n" in section("Hooks")
    assert {parameter.name for parameter in bare} <= set(rows(section("Hooks")))


@pytest.mark.parametrize("interface", INTERFACES, ids=lambda interface: interface.__name__)
def test_every_interface_is_told_as_it_is(interface: type) -> None:
    for name in members(interface):
        member = inspect.getattr_static(interface, name)
        said = f"property `{name}`" if isinstance(member, property) else f"\n{signature(member)}\n"
        assert said in TEXT


def test_every_protocol_of_the_sdk_is_among_them() -> None:
    files = (file for file in SDK.glob("*.py") if file.name != "hookspecs.py")
    found = {name for file in files for name in re.findall(r"^class (\w+)\(Protocol\)", file.read_text(), re.MULTILINE)}
    # A driver is a class that authors inherit from.
    assert found | {drivers.Driver.__name__} == {interface.__name__ for interface in INTERFACES}


@pytest.mark.parametrize(
    "module",
    [driver, importers, kinematics, mobile, models, physics, rays, vehicles],
    ids=lambda module: module.__name__,
)
def test_every_field_of_a_value_is_told(module: ModuleType) -> None:
    for name, fields in values(module).items():
        table = re.search(rf"^\| `{name}` \|(.*)\|\n((?:\|.*\n)*)", TEXT, re.MULTILINE)
        assert table, f"{name} has no table and no row"
        in_row = re.findall(r"`(\w+)`", table[1])
        assert in_row == fields or list(rows(table[2])) == fields, name


def test_times_and_sizes_are_those_of_the_code() -> None:
    told = section("Where components run")
    assert f"has {LOOK_SECONDS:g} seconds for import and factory" in told
    assert LOOK_SECONDS == START_SECONDS == LOADING_SECONDS
    assert f"may grow by {MEMORY_GROWTH_BYTES >> 20} MiB" in told
    check = section("Kinematics").replace("\n", " ")
    assert f"at {selfcheck.POSTURES} random postures" in check
    assert f"(to {selfcheck.POSE_TOLERANCE:.0e} m and rad)".replace("e-0", "e-") in check
    assert f"(to {selfcheck.JACOBIAN_TOLERANCE:.0e} of its".replace("e-0", "e-") in check


def test_names_of_enumerations_are_told() -> None:
    for enumeration in (
        drivers.Pace,
        drivers.Mode,
        drivers.Safety,
        vehicles.DriveQuantity,
        kinematics.InverseStatus,
        registration.Isolation,
    ):
        assert enumeration.__name__ in TEXT
        assert [one.name for one in enumeration if f"`{one.name}`" not in TEXT.replace("Isolation.", "")] == []
    assert list(rows(section("Refusals and faults"))) == [
        *(error.__name__ for error in (errors.ArgumentError, errors.FilesNeeded)),
        *(kind.name for kind in errors.FaultKind),
    ]


def test_the_laws_are_told_in_order() -> None:
    told = [name for name in rows(section("The test kit")) if name in LAWS]
    assert told == list(LAWS)
    attributes = [name for name in KinematicsContract.__annotations__ if name not in ("examination", "problem")]
    assert [name for name in rows(section("The test kit")) if name in attributes] == attributes


@pytest.mark.parametrize("name", [name for name in testing.__all__ if name.endswith("Contract")])
def test_the_classes_of_the_kit_are_told(name: str) -> None:
    assert f"`{name}`" in section("The test kit")
    contract = getattr(testing, name)
    if contract is KinematicsContract:
        return
    laws, facts = rows(section("The test kit"))[name].split("|")
    assert re.findall(r"`(\w+)`", laws) == list(contract.laws)
    module = sys.modules[contract.__module__]
    (own,) = [one for name, one in vars(module).items() if name.endswith("Facts") and dataclasses.is_dataclass(one)]
    assert re.findall(r"`(\w+)`", facts) == [
        getattr(own, "__name__", ""),
        *(field.name for field in dataclasses.fields(own)),
    ]


def test_every_suite_of_the_kit_is_at_hand() -> None:
    files = (SDK / "testing").glob("*.py")
    suites = {name for file in files for name in re.findall(r"^class (\w+Contract)\b", file.read_text(), re.MULTILINE)}
    assert suites - {"ComponentContract"} <= set(testing.__all__)


def test_the_modules_that_are_named_are_there() -> None:
    named = rows(section("Helpers"))
    assert [name for name in named if not ((SDK / f"{name}.py").exists() or (SDK / name).is_dir())] == []
    for name, text in named.items():
        for word in re.findall(r"`(\w+)`", text):
            source = SDK / f"{name}.py"
            if source.exists():
                assert re.search(rf"^(?:def|class) {word}\b", source.read_text(), re.MULTILINE), f"{name}.{word}"
