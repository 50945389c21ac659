"""The laws as a pytest class that authors subclass."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.chains import kit_chains
from virtualrobot_sdk.testing.examination import LAWS, Examination, Finding, State
from virtualrobot_sdk.testing.laws import branches, complete
from virtualrobot_sdk.testing.seeds import seed_or_drawn
from virtualrobot_sdk.testing.subject import locate


class KinematicsContract:
    """Contract of all kinematics components; subclass it in a test file.

        class TestMyArm(KinematicsContract):
            component = "my_package/my_arm"

    Each law is a test on each chain. A chain that the component declines by an ArgumentError is skipped; at least one
    must be taken. The component runs in processes of its own, so that a hang or a crash fails one test with its name.

    Attributes:
        component: `my_arm` (of an installed plugin), `my_package/my_arm` (the plugin's module and the component's
            name) or `my_package.arm:MyArm` (something that makes the component of a chain).
        settings: plain values, as in a scene file.
        chains: by name; those of the kit, and whatever is added.
        complete: true where the component claims to return all solutions within limits.
        seed: seed of the random postures; None: VIRTUALROBOT_TEST_SEED or a new one; a failed test prints it.
    """

    component: ClassVar[str]
    settings: ClassVar[Mapping[str, Any]] = {}
    chains: ClassVar[Mapping[str, SerialChain]] = kit_chains()
    complete: ClassVar[bool] = False
    seed: ClassVar[int | None] = None
    examination: ClassVar[Examination | None] = None
    problem: ClassVar[str] = ""

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make a test of each chain and law."""
        for name, values in (("law", LAWS), ("chain", self.chains)):
            if name in metafunc.fixturenames:
                metafunc.parametrize(name, values)

    @classmethod
    def setup_class(cls) -> None:
        """Find the component; its processes start when a law needs them."""
        seed = seed_or_drawn(cls.seed)
        cls.examination = None
        try:
            subject = locate(ComponentKind.KINEMATICS, cls.component, cls.settings)
        except (PluginError, ComponentFault) as error:
            cls.problem = f"{cls.component}: {error}"
            return
        cls.examination = Examination(subject, cls.chains, seed)

    @classmethod
    def teardown_class(cls) -> None:
        """End the processes."""
        if cls.examination is not None:
            cls.examination.close()

    def test_law(self, chain: str, law: str) -> None:
        """Try a law on a chain."""
        examination = self._tried()
        _judge(examination, examination.examine(law, LAWS[law], chain))

    def test_solutions(self, chain: str) -> None:
        """Count solutions; all must be there where the component says so."""
        examination = self._tried()
        _judge(examination, examination.examine("solutions", complete if self.complete else branches, chain))

    def test_a_chain_is_taken(self) -> None:
        """At least one chain must not be declined."""
        if self.examination is None:
            pytest.fail(self.problem, pytrace=False)
        found = [self.examination.made(chain) for chain in self.chains]
        for finding in found:
            if finding.state is State.FAILED:
                _judge(self.examination, finding)
        if not any(finding.state is State.OK for finding in found):
            reasons = "\n".join(f"{finding.chain}: {finding.said}" for finding in found)
            pytest.fail(f"all chains are declined:\n{reasons}", pytrace=False)

    def _tried(self) -> Examination:
        """Return the component's processes; skip the test when there is no such component."""
        if self.examination is None:
            pytest.skip(self.problem)
        return self.examination


def _judge(examination: Examination, finding: Finding) -> None:
    """Fail or skip the test that a finding is about."""
    __tracebackhide__ = True
    print(f"seed: {examination.seed} (repeat with `seed = {examination.seed}` in the class)")
    if finding.state is State.FAILED:
        pytest.fail(f"{finding.law} on {finding.chain}: {finding.said}", pytrace=False)
    if finding.state is not State.OK:
        pytest.skip(f"{finding.state.value}: {finding.said}")
    if finding.measured is not None:
        print(f"tried: {finding.measured.tried}, worst: {dict(finding.measured.worst)} {finding.measured.note}")
