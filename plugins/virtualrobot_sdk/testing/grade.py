"""A component's grade: every law on every chain, what a call costs and which solutions it knows."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import click
import numpy as np

from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing import laws
from virtualrobot_sdk.testing.bench import own_chains
from virtualrobot_sdk.testing.chains import kit_chains
from virtualrobot_sdk.testing.examination import LAWS, Examination, Finding, State
from virtualrobot_sdk.testing.laws import EXISTING, RETURNED
from virtualrobot_sdk.testing.report import Cost, Report, Row, Solutions, text
from virtualrobot_sdk.testing.seeds import seed_or_drawn
from virtualrobot_sdk.testing.subject import locate


def grade(
    component: str,
    settings: Mapping[str, Any] | None = None,
    *,
    chains: Mapping[str, SerialChain] | None = None,
    complete: bool = False,
    seed: int | None = None,
) -> Report:
    """Return how well a kinematics component keeps the laws.

    Args:
        component: `my_arm` (of an installed plugin), `my_package/my_arm` (the plugin's module and the component's
            name) or `my_package.arm:MyArm` (something that makes the component of a chain).
        settings: plain values, as in a scene file.
        chains: by name; None: those of the kit.
        complete: true: it is a law too that all solutions within limits are returned.
        seed: the seed of the random postures; None: that of VIRTUALROBOT_TEST_SEED, or another each time.

    Raises PluginError when there is no such component, and PluginError or ComponentFault when its plugin fails.
    """
    seed = seed_or_drawn(seed)
    subject = locate(ComponentKind.KINEMATICS, component, settings or {})
    examination = Examination(subject, kit_chains() if chains is None else chains, seed)
    try:
        return _graded(examination, complete)
    finally:
        examination.close()


def _graded(examination: Examination, complete: bool) -> Report:
    made = [examination.made(chain) for chain in examination.chains]
    taken = tuple(finding.chain for finding in made if finding.state is State.OK)
    rows = [_made_row(made)]
    solutions: list[Solutions] = []
    cost: list[Cost] = []
    if taken:
        rows += [_row(law, [examination.examine(law, LAWS[law], chain) for chain in taken]) for law in LAWS]
        name, law = ("complete", laws.complete) if complete else ("solutions", laws.branches)
        counted = [examination.examine(name, law, chain) for chain in taken]
        for finding in counted:
            if finding.measured is not None and finding.measured.tried:
                found = finding.measured
                counts = int(found.worst[RETURNED]), int(found.worst[EXISTING])
                solutions.append(Solutions(finding.chain, found.tried, *counts))
        timed, times = examination.cost(taken[0])
        cost = [_cost(method, *seconds) for method, seconds in times.items()]
        # What is only counted and timed has a row where that failed.
        for what, findings in ((name, counted), ("cost", [timed])):
            if what == "complete" or any(finding.state is State.FAILED for finding in findings):
                rows.append(_row(what, findings))
    return Report(
        examination.subject.component,
        examination.seed,
        taken,
        {finding.chain: finding.said for finding in made if finding.state is State.DECLINED},
        tuple(rows),
        tuple(solutions),
        taken[0] if cost else "",
        tuple(cost),
    )


def _made_row(made: Sequence[Finding]) -> Row:
    faults = {finding.chain: finding.said for finding in made if finding.state is State.FAILED}
    if not faults and all(finding.state is State.DECLINED for finding in made):
        reasons = {finding.said for finding in made}
        right = reasons.pop() if len(reasons) == 1 else "give it one that it is made for"
        faults = {"every chain": f"it declines all: {right}"}
    return Row("made", State.FAILED if faults else State.OK, sum(f.state is State.OK for f in made), {}, faults)


def _row(law: str, findings: Sequence[Finding]) -> Row:
    """Return what came of a law on several chains as one row."""
    measured = [finding.measured for finding in findings if finding.measured is not None]
    worst: dict[str, float] = {}
    for one in measured:
        for unit, value in one.worst.items():
            worst[unit] = max(value, worst.get(unit, 0.0))
    said = {finding.chain: finding.said for finding in findings if finding.state is State.FAILED}
    state = State.FAILED if said else State.OK if measured else State.NOT_TRIED
    return Row(law, state, sum(one.tried for one in measured), worst, said)


def _cost(method: str, inside: np.ndarray, through: np.ndarray) -> Cost:
    numbers = [float(1e6 * f(seconds)) for seconds in (inside, through) for f in (np.median, _p99)]
    return Cost(method, *numbers)


def _p99(seconds: np.ndarray) -> float:
    return float(np.percentile(seconds, 99))


@click.command()
@click.argument("component")
@click.option("--settings", default="{}", metavar="JSON", help="The component's settings.")
@click.option("--chains", metavar="MODULE:NAME", help="Your own chains by name, in place of those of the kit.")
@click.option("--complete", is_flag=True, help="Fail unless all solutions within limits are returned.")
@click.option("--seed", type=int, help="Repeat the postures of another grade.")
def command(component: str, settings: str, chains: str | None, complete: bool, seed: int | None) -> int:
    """Try COMPONENT on several arms and show which laws it keeps.

    COMPONENT is the name of an installed one, PACKAGE/NAME, or PACKAGE.MODULE:FACTORY.
    """
    try:
        given = json.loads(settings)
    except ValueError as error:
        raise click.UsageError(f"--settings is no JSON: {error}") from error
    if not isinstance(given, dict):
        raise click.UsageError(f'--settings is {settings}; it must be an object: {{"name": value}}')
    try:
        own = own_chains(chains) if chains else None
        report = grade(component, given, chains=own, complete=complete, seed=seed)
    except (PluginError, ComponentFault) as error:
        click.echo(f"{component} cannot be graded: {error}", err=True)
        return 1
    click.echo(text(report))
    return 0 if report.passed else 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `virtualrobot grade`; return 0 when all laws are kept, 1 when one is not, 2 for wrong usage.

    Modules of the current folder can be graded without being installed.
    """
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        return int(command.main(arguments, prog_name="virtualrobot grade", standalone_mode=False) or 0)
    except click.ClickException as error:
        error.show()
        return error.exit_code
