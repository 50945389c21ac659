"""The pytest class that the suites of all kinds of components share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, PluginError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.seeds import seed_or_drawn
from virtualrobot_sdk.testing.subject import locate
from virtualrobot_sdk.testing.trial import Law, NotTried, Trial, examine


class ComponentContract:
    """Contract of all components of one kind; authors subclass the class of their kind in a test file.

    Each law is a test. The component runs in a process of its own, so that a hang or a crash fails one test with its
    name; there, arguments are arrays that cannot be written to.

    Attributes:
        kind: the component's kind (set by the class of the kind).
        laws: by name (set by the class of the kind).
        facts: properties of the component that its author states.
        component: `my_lidar` (of an installed plugin), `my_package/my_lidar` (the plugin's module and the component's
            name) or `my_package.lidar:MyLidar` (something that makes the component, without settings).
        settings: plain values, as in a scene file.
        seed: seed of the random values; None: VIRTUALROBOT_TEST_SEED or a new one; a failed test prints it.
    """

    kind: ClassVar[ComponentKind]
    laws: ClassVar[Mapping[str, Law]]
    facts: ClassVar[Any]
    component: ClassVar[str]
    settings: ClassVar[Mapping[str, Any]] = {}
    seed: ClassVar[int | None] = None
    trial: ClassVar[Trial[Any]]

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make a test of each law."""
        if "law" in metafunc.fixturenames:
            metafunc.parametrize("law", self.laws)

    @classmethod
    def setup_class(cls) -> None:
        """Make the component."""
        for name in ("component", "facts"):
            if not hasattr(cls, name):
                pytest.fail(f"{cls.__name__} does not say its `{name}`", pytrace=False)
        cls._drawn = seed_or_drawn(cls.seed)
        failed = ""
        try:
            cls.trial = Trial(cls.kind, locate(cls.kind, cls.component, cls.settings), cls.facts)
        except (ArgumentError, PluginError, ComponentFault) as error:
            failed = f"{cls.component}: {error}"
        if failed:
            pytest.fail(failed, pytrace=False)

    @classmethod
    def teardown_class(cls) -> None:
        """End the process."""
        cls.trial.close()

    def test_law(self, law: str) -> None:
        """Try a law."""
        __tracebackhide__ = True
        print(f"seed: {self._drawn} (repeat with `seed = {self._drawn}` in the class)")
        outcome = self._outcome(law)
        if isinstance(outcome, LawBroken):
            pytest.fail(f"{law}: {outcome}", pytrace=False)
        if isinstance(outcome, NotTried):
            pytest.skip(f"not tried: {outcome}")
        print(f"tried: {outcome.tried}, worst: {dict(outcome.worst)} {outcome.note}")

    def _outcome(self, law: str) -> Measured | LawBroken | NotTried:
        try:
            return examine(self.laws[law], self.trial, self._drawn)
        except (LawBroken, NotTried) as outcome:
            return outcome

    _drawn: ClassVar[int]
