"""Strategies of searches: which parameters the next generation has, by the results of those before.

Each follows from its random numbers and from what it was told alone, so a search that is resumed comes to the same.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from virtualrobot_apps.studies.parameters import Choice, Floats, Law, Value
from virtualrobot_apps.studies.study_file import SearchFor

Rows = list[dict[str, Value]]


class Strategy(Protocol):
    """Search that asks for generations and is told their costs."""

    def ask(self) -> Rows:
        """Return the parameters of the next generation, by name, a row for each cell."""
        ...

    def tell(self, costs: Floats) -> None:
        """Take the costs (cells, goals) of the generation; less is better."""
        ...


def strategy_of(search: SearchFor, drawn: Sequence[Law | Choice], rng: np.random.Generator) -> Strategy:
    """Return what a search asks by: CMA-ES for two ranges or more and one goal, NSGA-II for choices and several."""
    laws = [one for one in drawn if isinstance(one, Law)]
    if len(search.goals) == 1 and len(laws) == len(drawn) > 1:
        return Evolution(search, laws, rng)
    return Genetic(search, drawn, rng)


class Evolution:
    """CMA-ES: Nikolaus Hansen, "The CMA evolution strategy: a tutorial", 2016.

    What it draws is a point of the unit cube, whose sides are the parameters' ranges. A search that has converged
    begins again at a place that is drawn.
    """

    def __init__(self, search: SearchFor, laws: Sequence[Law], rng: np.random.Generator) -> None:
        """Begin in the middle of all ranges."""
        self._search, self._laws, self._rng = search, laws, rng
        self._strategy = self._begun(np.full(len(laws), 0.5))
        self._points = list[Floats]()

    def ask(self) -> Rows:
        """Return the parameters of the next generation, by name, a row for each cell."""
        self._points = [np.clip(point, 0.0, 1.0) for point in self._strategy.ask()]
        return [
            {law.name: law.quantiles(point[one : one + 1])[0] for one, law in enumerate(self._laws)}
            for point in self._points
        ]

    def tell(self, costs: Floats) -> None:
        """Take the costs (cells, 1) of the generation; less is better."""
        self._strategy.tell(self._points, list(costs[:, 0]))
        if self._strategy.stop():
            self._strategy = self._begun(self._rng.uniform(size=len(self._laws)))

    def _begun(self, start: Floats):  # noqa: ANN202 (cma has no types)
        import cma

        options = {"bounds": [0.0, 1.0], "popsize": self._search.population, "verbose": -9, "seed": np.nan}
        # Its own random numbers, so that those of NumPy stay as functions find them.
        options["randn"] = lambda *shape: self._rng.standard_normal(shape)
        return cma.CMAEvolutionStrategy(start, 0.25, options)


class Genetic:
    """NSGA-II, by Optuna: Kalyanmoy Deb et al., "A fast and elitist multiobjective genetic algorithm", 2002."""

    def __init__(self, search: SearchFor, drawn: Sequence[Law | Choice], rng: np.random.Generator) -> None:
        """Begin with a generation that is drawn evenly."""
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._search = search
        # Ranges are crossed and changed as the paper has it; values of lists are taken from one parent, or anew.
        kinds = optuna.samplers.nsgaii
        with warnings.catch_warnings():
            # Their interface may change, says Optuna of both: here alone they are made.
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.NSGAIISampler(
                population_size=search.population,
                crossover=kinds.SBXCrossover(),
                mutation=kinds.PolynomialMutation(),
                seed=int(rng.integers(2**31)),
            )
        self._study = optuna.create_study(
            directions=[optuna.study.StudyDirection.MINIMIZE] * len(search.goals), sampler=sampler
        )
        self._drawn: dict[str, optuna.distributions.BaseDistribution] = {}
        for one in drawn:
            if isinstance(one, Choice):
                self._drawn[one.name] = optuna.distributions.CategoricalDistribution(one.values)
            else:
                low, high = (float(end) for end in one.quantiles(np.array([0.0, 1.0])))
                self._drawn[one.name] = optuna.distributions.FloatDistribution(low, high)
        self._trials: list[optuna.Trial] = []

    def ask(self) -> Rows:
        """Return the parameters of the next generation, by name, a row for each cell."""
        self._trials = [self._study.ask(self._drawn) for _ in range(self._search.population)]
        return [dict(trial.params) for trial in self._trials]

    def tell(self, costs: Floats) -> None:
        """Take the costs (cells, goals) of the generation; less is better."""
        for trial, cost in zip(self._trials, costs.tolist(), strict=True):
            self._study.tell(trial, cost)
