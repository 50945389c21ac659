"""Loading of one plugin: what it registers, and each way in which it may be wrong."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.hookspecs import API_VERSION, ENTRY_POINT_GROUP, HOOKS
from virtualrobot_sdk.loading import load
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration

HEAD = """
from dataclasses import dataclass
from functools import partial
from virtualrobot_sdk.hookspecs import hookimpl
from virtualrobot_sdk.registration import Isolation

@dataclass(frozen=True)
class Settings:
    gain: float = 1.0

@dataclass
class Loose:
    gain: float = 1.0

@dataclass(frozen=True)
class Unknown:
    gain: "NoSuchType" = None

def arm(chain):
    '''Make an arm.

    And more about it.
    '''

def set_arm(chain, settings): ...

def reader(): ...

class Arm:
    '''An arm as a class.'''
    def __init__(self, chain, settings): ...
"""
VERSION = 'api_version = "1.0"\n'
KINEMATICS = "@hookimpl\ndef virtualrobot_register_kinematics(register):\n    "
MODELS = "@hookimpl\ndef virtualrobot_register_models(register):\n    "
IMPORTERS = "@hookimpl\ndef virtualrobot_register_importers(register):\n    "

Plugin = Callable[..., tuple[str, tuple[Registration, ...], tuple[Model, ...]]]


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Plugin]:
    """Return what writes a module and loads it as a plugin."""
    monkeypatch.syspath_prepend(tmp_path)
    name = f"plugin_{tmp_path.parent.name}_{tmp_path.name}".replace("-", "_")

    def write(text: str, attribute: str = "") -> tuple[str, tuple[Registration, ...], tuple[Model, ...]]:
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        return load(EntryPoint("mine", name + attribute, ENTRY_POINT_GROUP))

    yield write
    sys.modules.pop(name, None)


def test_a_plugin_registers_components_of_each_kind(plugin: Plugin) -> None:
    version, found, _ = plugin(
        HEAD
        + VERSION
        + KINEMATICS
        + "register('arm', arm); "
        + "register('set-arm_2', Arm, Settings, isolation=Isolation.IN_PROCESS, deadline_seconds=2); "
        + "register('part', partial(set_arm, settings=None))\n"
        + IMPORTERS
        + "register('step', reader, ['.stp', '.tar.gz'])\n"
    )
    assert version == "1.0"
    arm, set_arm, part, step = found
    assert (arm.kind, arm.name, arm.config_type) == (ComponentKind.KINEMATICS, "arm", None)
    assert (arm.isolation, arm.deadline_seconds, arm.endings) == (Isolation.PROCESS, 1.0, ())
    assert arm.description == "Make an arm."
    assert (set_arm.isolation, set_arm.deadline_seconds) == (Isolation.IN_PROCESS, 2.0)
    assert set_arm.config_type is not None and set_arm.config_type.__name__ == "Settings"
    assert set_arm.description == "An arm as a class."
    assert isinstance(part.factory, functools.partial) and part.description == ""
    assert (step.kind, step.endings, step.deadline_seconds) == (ComponentKind.IMPORTER, (".stp", ".tar.gz"), 60.0)


def test_a_plugin_may_be_an_object(plugin: Plugin) -> None:
    text = HEAD + (
        "class Own:\n"
        "    api_version = '1.0'\n"
        "    @hookimpl\n"
        "    def virtualrobot_register_kinematics(self, register): register('arm', arm)\n"
        "own = Own()\n"
    )
    version, (arm,), _ = plugin(text, ":own")
    assert (version, arm.name) == ("1.0", "arm")


def models(text: str) -> str:
    return HEAD + VERSION + "from virtualrobot_sdk.models import Model\n" + MODELS + text + "\n"


def test_a_plugin_of_models_alone_is_one(plugin: Plugin) -> None:
    fields = "uri='package://mine/arm.urdf', package='mine-data', settings={'arguments': {'a': 'b'}}"
    text = f"register(Model('arm', 'An arm', {fields}))"
    _, components, (arm,) = plugin(models(text))
    assert (components, arm.name, arm.installed, arm.settings["arguments"]) == ((), "arm", False, {"a": "b"})


def test_each_kind_of_component_has_a_hook() -> None:
    assert set(HOOKS) == set(ComponentKind)


def body(text: str) -> str:
    return HEAD + VERSION + KINEMATICS + text + "\n"


def importers(text: str) -> str:
    return HEAD + VERSION + IMPORTERS + text + "\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        # Models
        (models("register('arm')"), "'arm' is registered as a model; it must be a virtualrobot_sdk.models.Model"),
        (models("register(Model('Arm', 'x', scene='x'))"), r"the model 'Arm' is not as it must be: .*\$.name"),
        (models("register(Model('arm', 'x', scene='x', axes=-1))"), r"the model 'arm' is not .*\$.axes"),
        (models("register(Model('arm', 'x'))"), "'arm' has neither uri nor scene; give one of them"),
        (models("register(Model('arm', 'x', scene='x', uri='package://a/b'))"), "'arm' has both uri and scene"),
        (models("register(Model('arm', 'x', uri='/b.urdf'))"), "'/b.urdf'; it must be package://PACKAGE/FILE"),
        (models("[register(Model('arm', 'x', scene='x')) for _ in '12']"), "the model 'arm' is registered twice"),
        # Import
        (
            "import no_such_library",
            r"cannot be imported: ModuleNotFoundError: No module named 'no_such_library' \(plugin_",
        ),
        ("\n\n1 / 0", r"cannot be imported: ZeroDivisionError: division by zero \(plugin_\w+.py:3\)"),
        ("def f(:", r"cannot be imported: SyntaxError: invalid syntax \(plugin_\w+.py:1\)"),
        ("import sys; sys.exit(2)", "cannot be imported: SystemExit: 2"),
        # Version
        (HEAD, f"has no api_version: write `api_version = '{API_VERSION}'`"),
        ("api_version = 1", "its api_version is 1: write"),
        ("api_version = 'new'", "its api_version is 'new': write"),
        ("api_version = '2.0'", f"it was written for API 2.0; this kernel has {API_VERSION}; install a newer"),
        ("api_version = '1.9'", f"it was written for API 1.9; this kernel has {API_VERSION}; install a newer"),
        ("api_version = '0.9'", f"it was written for API 0.9; this kernel has {API_VERSION}"),
        # Hooks
        (HEAD + VERSION, "registers nothing; a plugin has one of virtualrobot_register_kinematics, "),
        (body("pass"), "registers nothing"),
        (body("").replace("@hookimpl", "") + "    pass", "virtualrobot_register_kinematics is not marked as a hook"),
        (
            body("pass").replace("register_kinematics", "register_kinematic"),
            "no hook virtualrobot_register_kinematic; did you mean virtualrobot_register_kinematics?",
        ),
        (body("pass").replace("virtualrobot_register_kinematics", "begin"), "no hook begin; there is virtualrobot_"),
        (body("pass").replace("(register)", "(registry)"), r"takes \(registry\); it must take \(register\)"),
        (body("pass").replace("(register)", "()"), r"takes \(\); it must take \(register\)"),
        (body("pass").replace("(register)", "(*, register)"), r"takes \(\*, register\); it must take \(register\)"),
        (
            body("raise KeyError('x')"),
            r"kinematics raises KeyError: 'x' \(plugin_\w+.py:\d+ in virtualrobot_register_kin",
        ),
        (body("register('arm')"), r"missing 1 required positional argument: 'factory' \(plugin_\w+.py:\d+ in virtual"),
        (body("import sys; sys.exit()"), "virtualrobot_register_kinematics raises SystemExit"),
        # What is registered
        (body("register('Arm', arm)"), "the name 'Arm' is not one of a component; it is made of small letters"),
        (body("register('', arm)"), "the name '' is not"),
        (body("register('7axes', arm)"), "the name '7axes' is not"),
        (body("register(None, arm)"), "the name None is not"),
        (body("register('arm', arm); register('arm', arm)"), "kinematics 'arm' is registered twice"),
        (body("register('arm', 'arm')"), r"factory of 'arm' is 'arm'; it must be something to call: factory\(chain\)"),
        (body("register('arm', set_arm)"), r"takes \(chain, settings\); it is called as factory\(chain\)"),
        (body("register('arm', arm, Settings)"), r"takes \(chain\); it is called as factory\(chain, settings\)"),
        (
            body("register('arm', set_arm, Loose)"),
            "config_type of 'arm' is .*Loose.*must be a dataclass with frozen=True",
        ),
        (body("register('arm', set_arm, {})"), "config_type of 'arm' is {}; it must be a dataclass"),
        (body("register('arm', set_arm, Unknown)"), "settings Unknown of 'arm' have no schema: name 'NoSuchType'"),
        (body("register('arm', arm, isolation='process')"), "is 'process'; it must be Isolation.IN_PROCESS or Isol"),
        (body("register('arm', arm, deadline_seconds=0)"), "deadline of 'arm' is 0; it must be a positive number"),
        (body("register('arm', arm, deadline_seconds=float('inf'))"), "deadline of 'arm' is inf; it must"),
        (body("register('arm', arm, deadline_seconds=float('nan'))"), "deadline of 'arm' is nan; it must"),
        (body("register('arm', arm, deadline_seconds='1')"), "deadline of 'arm' is '1'; it must"),
        (importers("register('step', reader)"), "missing 1 required positional argument: 'endings'"),
        (
            importers("register('step', reader, '.stp')"),
            r"endings of 'step' have '.stp'; they are a list .*\('.stp', '.step'\)",
        ),
        (importers("register('step', reader, ())"), r"endings of 'step' have \(\); they are a list"),
        (importers("register('step', reader, ('.stp', '.STEP'))"), "endings of 'step' have '.STEP'; they"),
        (importers("register('step', reader, ['stp'])"), "endings of 'step' have 'stp'; they"),
        (importers("register('step', reader, [None])"), "endings of 'step' have None; they"),
        (importers("register('step', arm, ['.stp'])"), r"takes \(chain\); it is called as factory\(\)"),
    ],
)
def test_what_is_wrong_is_named_with_what_would_be_right(plugin: Plugin, text: str, said: str) -> None:
    with pytest.raises(PluginError, match=said):
        plugin(text)


def test_an_entry_point_that_names_nothing_is_refused(plugin: Plugin) -> None:
    with pytest.raises(PluginError, match=r"'no_such_module' cannot be imported: .*No module named 'no_such_module'"):
        load(EntryPoint("mine", "no_such_module", ENTRY_POINT_GROUP))
    with pytest.raises(PluginError, match="has no attribute 'nothing'"):
        plugin(HEAD, ":nothing")
    with pytest.raises(PluginError, match=r"'\?' cannot be imported"):
        load(EntryPoint("mine", "?", ENTRY_POINT_GROUP))


def test_the_error_keeps_what_caused_it(plugin: Plugin) -> None:
    with pytest.raises(PluginError) as raised:
        plugin(body("raise KeyError('x')"))
    assert isinstance(raised.value.__cause__, KeyError)
