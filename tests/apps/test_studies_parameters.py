"""Cells of studies: parameters by grids and laws, from a cell's number alone; and what study files may not say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.studies.parameters import RANDOM, SENSITIVITY, SOBOL, Cells, Law, Values, generator
from virtualrobot_apps.studies.study_file import Study, read_study

TWO = "parameters: {a: {range: [0, 1]}, b: {range: [0, 1]}}"
HEAD = "schema_version: 1\nfunction: pick:pick\nresults: {y: number}\n"


def law(name: str, law: str, **settings: float) -> Law:
    return Law(name, law, tuple(settings.items()))


def written(folder: Path, text: str) -> Study:
    file = folder / "study.yaml"
    file.write_text(HEAD + text)
    return read_study(file)


def test_a_grid_goes_through_all_combinations_and_its_last_parameter_first() -> None:
    cells = Cells((Values("a", (1, 2)), Values("b", ("x", "y", "z"))), draws=2, sampling=RANDOM, seed=0)
    found = cells.between(0, cells.count)
    assert [(one["a"], one["b"]) for one in found[::2]] == [(a, b) for a in (1, 2) for b in "xyz"]
    assert found[::2] == found[1::2]
    assert cells.point(7) == {"a": 2, "b": "x"}


@pytest.mark.parametrize("sampling", [RANDOM, SOBOL, SENSITIVITY])
def test_cells_do_not_depend_on_those_that_are_asked_for_with_them(sampling: str) -> None:
    laws = (Values("a", (1, 2, 3)), law("x", "norm", scale=2.0), law("u", "uniform", loc=1.0, scale=3.0))
    cells = Cells(laws, draws=8, sampling=sampling, seed=5)
    whole = cells.between(0, cells.count)
    parts = (cells.between(first, min(first + 5, cells.count)) for first in range(0, cells.count, 5))
    assert [one for part in parts for one in part] == whole
    assert all(1.0 < one["u"] < 4.0 for one in whole if isinstance(one["u"], float))


@pytest.mark.parametrize(
    ("drawn", "expected"),
    [
        (law("x", "norm", loc=1.0, scale=2.0), stats.norm(1.0, 2.0)),
        (law("x", "gamma", a=3.0), stats.gamma(3.0)),
        (law("x", "uniform", loc=-1.0, scale=3.0), stats.uniform(-1.0, 3.0)),
    ],
    ids=["norm", "gamma", "uniform"],
)
@pytest.mark.parametrize("sampling", [RANDOM, SOBOL])
def test_draws_follow_their_law(drawn: Law, expected: stats.rv_continuous, sampling: str) -> None:
    """By the test of Kolmogorov and Smirnov; the seed is fixed."""
    cells = Cells((drawn,), draws=1024, sampling=sampling, seed=11)
    values = [float(one["x"]) for one in cells.between(0, 1024)]
    assert stats.kstest(values, expected.cdf).pvalue > 0.01


def test_a_law_of_whole_numbers_gives_these() -> None:
    values = [one["n"] for one in Cells((law("n", "poisson", mu=4.0),), 2000, RANDOM, 3).between(0, 2000)]
    assert all(isinstance(value, int) for value in values)
    # The mean of 2000 draws is normal with the deviation sqrt(4 / 2000) = 0.045.
    assert abs(np.mean(np.array(values, dtype=float)) - 4.0) < 4 * 0.045


def test_a_cell_has_random_numbers_of_its_own() -> None:
    """NumPy's own Philox by seed and number; what a function draws is not what its parameters were drawn by."""
    expected = np.random.Generator(np.random.Philox(key=[7, 12])).normal(size=3)
    assert (generator(7, 12).normal(size=3) == expected).all()
    drawn = [generator(seed, number, part).random() for seed in (7, 8) for number in (12, 13) for part in (0, 1)]
    assert len(set(drawn)) == 8


def test_a_study_file_is_read(tmp_path: Path) -> None:
    study = written(
        tmp_path,
        "seed: 9\ndraws: 4\nblock: 3\nsampling: sobol\ncell_seconds: 2\nparameters:\n"
        "  a: {grid: {from: 0, to: 1, count: 3}}\n  b: {list: [1, 2]}\n  c: {range: [2, 5]}\n"
        "  d: {law: beta, a: 2, b: 3}\n",
    )
    assert (study.cells.count, study.block, study.cell_seconds, study.cells.seed) == (24, 3, 2.0, 9)
    a, b, c, d = study.cells.parameters
    assert (a, b) == (Values("a", (0.0, 0.5, 1.0)), Values("b", (1, 2)))
    assert (c, d) == (law("c", "uniform", loc=2.0, scale=3.0), law("d", "beta", a=2.0, b=3.0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("parameters: {x: {range: [1, 0]}}", "two numbers belong here, the lower one first"),
        ("parameters: {x: {range: [0, .nan]}}", "a finite number belongs here"),
        ("parameters: {x: {list: [1, nan]}}", "a finite number or a text belongs here, not nan"),
        ("parameters: {x: {list: [1, 1e999]}}", "a finite number or a text belongs here, not inf"),
        ("parameters: {x: {list: []}}", "one or more numbers belong here"),
        ("parameters: {x: {grid: {from: 0, to: 1}}}", "the field 'count' is missing"),
        ("parameters: {x: {law: normal}}", "scipy.stats has no law 'normal'; did you mean 'norm"),
        ("parameters: {x: {law: norm, scale: -1}}", "there is no law 'norm' with scale -1"),
        ("parameters: {x: {law: norm, sigma: 1}}", "the law 'norm' has no 'sigma'; it has loc, scale"),
        ("parameters: {x: {law: gamma}}", "the law 'gamma' needs 'a'"),
        ("parameters: {x: {law: norm, loc: nan}}", "a finite number belongs here"),
        ("parameters: {x: {between: [0, 1]}}", "one of list, grid, range, law belongs here"),
        ("parameters: {x: {list: [1], law: norm}}", "one of list, grid, range, law belongs here"),
        ("parameters: {}", "at least one belongs here"),
        ("parameters: {cell: {list: [1]}}", "'cell' is a column that every study has"),
        ("parameters: {y: {list: [1]}}", "'y' is a parameter, too"),
        ("parameters: {x-y: {list: [1]}}", "'x-y' is no name"),
        ("parameters: {x: {list: [1]}}\nsampling: sobol", "none is a range or a law"),
        ("parameters: {x: {law: norm}}\nsampling: sobol\ndraws: 100", "draws 128, not 100"),
        ("parameters: {x: {law: norm}}\nsampling: lhs", "it is one of random, sobol, sensitivity"),
        ("parameters: {x: {law: norm}}\nsampling: sensitivity\ndraws: 64", "of one parameter there is no share"),
        ("parameters: {x: {list: [1]}}\nseed: -1", "a whole number from 0"),
        ("parameters: {x: {list: [1]}}\nscene: none.yaml", "there is no file"),
        ("parameters: {x: {list: [1]}}\nsetup: pick", "module:function belongs here"),
        ("parameters: {x: {list: [1]}}\nparametres: 1", "there is no field 'parametres'; did you mean 'parameters'?"),
        ("parameters: {x: {range: [0, 1]}}\nsearch: {minimize: y, generations: 9}", "one alone is a grid's"),
        (f"{TWO}\nsearch: {{minimize: z, generations: 9}}", "'z' is not known; it is one of y"),
        (f"{TWO}\nsearch: {{generations: 9}}", "'minimize' or 'maximize' belongs here"),
        (f"{TWO}\nsearch: {{minimize: y, maximize: y, generations: 9}}", "'minimize' or 'maximize' belongs here"),
        (
            "parameters: {x: {law: norm}, z: {list: [1]}}\nsearch: {minimize: y, generations: 9}",
            "no laws: what is left",
        ),
        (f"{TWO}\nsearch: {{minimize: y}}", "the field 'generations' is missing"),
        (f"{TWO}\nsearch: {{minimize: y, generations: 9}}\ndraws: 3", "leave 'draws' and 'sampling' out"),
        ("parameters: {x: {list: [1, 2]}}\ndraws: 999999999", "of which a study has at most"),
    ],
)
def test_what_a_study_file_may_not_say(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(MalformedFileError) as error:
        written(tmp_path, text)
    assert said in str(error.value)
    assert str(error.value).startswith(f"{tmp_path / 'study.yaml'}:")
