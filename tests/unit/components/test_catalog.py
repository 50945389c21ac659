"""A name belongs to the plugin that had it first: no newcomer takes it over."""

from __future__ import annotations

from importlib.metadata import EntryPoint

from virtualrobot_kernel.components.catalog import OWN_PACKAGE, Offer, Plugin, _claims, _without_clashes
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.worker.description import ComponentDescription


def plugin(name: str, component: str, endings: tuple[str, ...] = (), package: str = "") -> Plugin:
    """Return a plugin that offers one component: kinematics, or an importer where there are endings."""
    kind = ComponentKind.IMPORTER if endings else ComponentKind.KINEMATICS
    about = ComponentDescription(kind, component, "", Isolation.PROCESS, 1.0, endings, {})
    return Plugin(name, package or name, "1.0", "1.0", (Offer(EntryPoint(name, name, "virtualrobot.plugins"), about),))


def catalogue(name: str, *models: str, package: str = "") -> Plugin:
    """Return a plugin that makes models known."""
    known = tuple(Model(model, "x", scene="x") for model in models)
    return Plugin(name, package or name, "1.0", "1.0", models=known)


def offering(plugins: tuple[Plugin, ...]) -> list[str]:
    return [one.name for one in plugins if one.offers]


def test_a_newcomer_does_not_take_a_name() -> None:
    working = (plugin("ours", "arm"),)
    found = _without_clashes((plugin("a_newcomer", "arm"), *working, plugin("other", "leg")), _claims(working))
    assert offering(found) == ["ours", "other"]
    assert (
        found[0].reason == "the kinematics component 'arm' is offered by the plugin 'ours' already; choose another name"
    )


def test_of_two_that_are_new_neither_is_taken() -> None:
    found = _without_clashes((plugin("one", "arm"), plugin("two", "arm"), plugin("three", "leg")), {})
    assert offering(found) == ["three"]
    said = "the kinematics component 'arm' is offered by 'two' as well: uninstall all but one"
    assert (found[0].reason, found[1].reason) == (said, said.replace("'two'", "'one'"))


def test_a_name_of_the_kernel_s_own_is_never_taken() -> None:
    own = plugin("kinematics", "chain", package=OWN_PACKAGE)
    foreign = plugin("a_chain", "chain")
    assert offering(_without_clashes((own, foreign), _claims((foreign,)))) == ["kinematics"]


def test_nobody_takes_the_name_of_a_model() -> None:
    own = catalogue("models", "ur5e", package=OWN_PACKAGE)
    mine, late, new = catalogue("mine", "my_arm"), catalogue("a_late_one", "my_arm"), catalogue("new", "ur5e", "x")
    found = _without_clashes((own, late, mine, new), _claims((mine,)))
    assert [one.name for one in found if one.models] == ["models", "mine"]
    assert found[1].reason == "the model 'my_arm' is offered by the plugin 'mine' already; choose another name"
    assert found[3].reason == "the model 'ur5e' is offered by the plugin 'models' already; choose another name"


def test_an_ending_is_a_name_too() -> None:
    found = _without_clashes((plugin("one", "a", (".x", ".y")), plugin("two", "b", (".y",))), {})
    assert offering(found) == []
    assert found[1].reason == "files '.y' are read by 'one' as well: uninstall all but one"
