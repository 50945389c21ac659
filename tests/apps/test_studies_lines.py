"""Lines of stations: by the recursion of each part, by queueing theory, and what they earn by tables of annuities."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError
from virtualrobot_apps.studies.economy import Money, annuity, earnings
from virtualrobot_apps.studies.flow import DOWN, WORK, Failures, Flow, Station, drawing, flow, generators
from virtualrobot_apps.studies.gantt import gantt
from virtualrobot_apps.studies.line_file import LineFile, open_line
from virtualrobot_apps.studies.parameters import Law

from tests.apps.studies import done, written

INF = math.inf


def exponential(mean: float) -> Law:
    return Law("", "expon", (("scale", mean),))


def test_every_part_leaves_when_the_recursion_says(rng: np.random.Generator) -> None:
    """Blocking after service: part n leaves station i when it is done there and part n - b - 1 has left the next one.

    C(i, n) = max(D(i-1, n), D(i, n-1)) + S(i, n), D(i, n) = max(C(i, n), D(i+1, n - b(i+1) - 1)); Yves Dallery, Stanley
    Gershwin, "Manufacturing flow line systems: a review of models and analytical results", 1992.
    """
    for _ in range(3):
        count, parts = int(rng.integers(2, 6)), 100
        law = Law("", "gamma", (("a", 2.0), ("scale", 20.0)))
        buffers = [0, *rng.integers(0, 4, count - 1).tolist()]
        stations = [Station(f"s{one}", law, buffer) for one, buffer in enumerate(buffers)]
        seed = int(rng.integers(2**32))
        served = [drawing("", law, its) for its in generators(np.random.default_rng(seed), count)]
        left = np.zeros((count + 1, parts))  # of each station, and of what is before the first one
        for part in range(parts):
            for station in range(1, count + 1):
                before = left[station, part - 1] if part else 0.0
                left[station, part] = max(left[station - 1, part], before) + served[station - 1]()
                # By the part that makes room, which is long done: stations are gone through part by part.
                if station < count and part > buffers[station]:
                    room = left[station + 1, part - buffers[station] - 1]
                    left[station, part] = max(left[station, part], room)
        found = flow(stations, np.random.default_rng(seed), left[-1, -1], kept=INF)
        last = [spell.end for spell in found.spells if spell.station == f"s{count - 1}" and spell.state == WORK]
        np.testing.assert_allclose(last[:parts], left[-1], rtol=1e-12)
        assert found.finished == parts


def waits(rng: np.random.Generator, station: Station, between: float) -> tuple[float, float, Flow]:
    """Return the mean time in the line of 14 long runs, its standard error, and the last run."""
    runs = [flow([station], rng, 2e5, 2e4, exponential(between)) for _ in range(14)]
    means = np.array([np.mean(one.lead_times) for one in runs])
    return float(means.mean()), float(means.std(ddof=1)) / math.sqrt(14.0), runs[-1]


@pytest.mark.parametrize(("machines", "law"), [(1, "expon"), (2, "expon"), (1, "always")])
@pytest.mark.long
def test_queues_are_as_long_as_theory_says(rng: np.random.Generator, machines: int, law: str) -> None:
    """M/M/1 and M/D/1 by Pollaczek and Khinchine, M/M/2 by Erlang C, at a load of 0.7; within four standard errors."""
    service, load = 70.0, 0.7
    between = service / load / machines
    cycle = exponential(service) if law == "expon" else service
    mean, error, last = waits(rng, Station("s", cycle, INF, machines), between)
    if machines == 1:
        wait = load / (1.0 - load) * service * (1.0 if law == "expon" else 0.5)
    else:
        offered = 2.0 * load
        late = offered**2 / 2.0 / (1.0 - load)
        wait = late / (1.0 + offered + late) * service / (2.0 * (1.0 - load))
    assert abs(mean - service - wait) < 4.0 * error < 0.2 * mean
    # John Little, "A proof for the queuing formula L = lambda W", 1961: but for what begins and ends within the time.
    assert last.inside == pytest.approx(last.throughput / 3600.0 * np.mean(last.lead_times), rel=0.02)
    assert last.shares["s"][WORK] == pytest.approx(load, abs=0.05)


@pytest.mark.parametrize("buffer", [0, 3])
@pytest.mark.long
def test_two_stations_with_a_buffer_do_what_hunt_says(rng: np.random.Generator, buffer: int) -> None:
    """Exponential times, always parts before: a queue M/M/1/K of K = buffer + 2 seen from the second station.

    It works but for p0 = (1 - r) / (1 - r^(K + 1)), r = 40/50; Gordon Hunt, "Sequential arrays of waiting lines", 1956.
    """
    ratio = 40.0 / 50.0
    expected = 3600.0 / 40.0 * (1.0 - (1.0 - ratio) / (1.0 - ratio ** (buffer + 3)))
    runs = [
        flow([Station("a", exponential(50.0)), Station("b", exponential(40.0), buffer)], rng, 4e4, 2e3).throughput
        for _ in range(10)
    ]
    error = float(np.std(runs, ddof=1)) / math.sqrt(10.0)
    assert abs(np.mean(runs) - expected) < 4.0 * error < 0.05 * expected


@pytest.mark.long
def test_breakdowns_cost_their_share(rng: np.random.Generator) -> None:
    """It works for 1 / (1 + repair / between) of the time, and waits for no one: 3600 / 50 / (1 + 300 / 3000) an hour.

    Two machines that wait for each other at once do 1 / (1 + sum of repair / between), if they share each stop: here
    the second one has no buffer before it and as good as no work (Buzacott, 1967).
    """
    weld = Station("weld", 50.0, failures=Failures(exponential(3000.0), exponential(300.0)))
    runs = [flow([weld], rng, 4e5) for _ in range(6)]
    error = float(np.std([one.throughput for one in runs], ddof=1)) / math.sqrt(6.0)
    assert abs(np.mean([one.throughput for one in runs]) - 72.0 / 1.1) < 4.0 * error < 2.0
    shares = runs[0].shares["weld"]
    assert shares[WORK] + shares[DOWN] == pytest.approx(1.0)


def test_what_always_takes_the_same_is_counted_by_hand() -> None:
    """10 s, then 20 s and one place between: parts leave at 30, 50, ... s; a half of its time the first is blocked."""
    stations = [Station("a", 10.0), Station("b", 20.0, 1)]
    found = flow(stations, np.random.default_rng(1), 1000.0, 100.0)
    assert (found.finished, found.throughput, found.bottleneck) == (50, 180.0, "b")
    assert found.shares["a"] == pytest.approx({"work": 0.5, "down": 0.0, "blocked": 0.5})
    assert found.shares["b"] == pytest.approx({"work": 1.0, "down": 0.0, "blocked": 0.0})
    # One on each station and one between them; for each the time that three take to leave.
    assert (found.inside, set(found.lead_times)) == (pytest.approx(3.0), {60.0})
    # As many as come: one in 25 s, of which none waits.
    slow = flow(stations, np.random.default_rng(1), 1000.0, 100.0, source=25.0)
    assert set(slow.lead_times) == {30.0} and slow.bottleneck == "b"


def test_waste_leaves_the_line(rng: np.random.Generator) -> None:
    """Of 4000 parts a fifth, within four deviations of a binomial."""
    found = flow([Station("a", 1.0, scrap=0.2), Station("b", 0.5, 1)], rng, 4000.0)
    assert abs(found.scrapped - 800) < 4.0 * math.sqrt(4000 * 0.2 * 0.8)
    assert abs(found.finished + found.scrapped - 4000) <= 2


def test_what_happens_at_a_station_changes_no_number_of_another() -> None:
    """Variants of a line see the same chance: the first station's spells are the same, whatever the second one is."""
    first = Station("a", exponential(30.0), failures=Failures(exponential(100.0), 20.0))
    spells = [
        [
            spell[2:5]
            for spell in flow([first, second], np.random.default_rng(3), 3000.0, kept=3000.0).spells
            if spell[0] == "a"
        ]
        for second in (Station("b", 1e-3, INF), Station("b", exponential(1e-3), INF, 3))
    ]
    assert spells[0] == spells[1]


def test_money_is_counted_as_in_tables() -> None:
    """Annuities of 5% over 10 years and 8% over 5: 0.129505 and 0.250456 (any table of capital recovery factors)."""
    assert annuity(0.05, 10.0) == pytest.approx(0.129505, abs=1e-6)
    assert annuity(0.08, 5.0) == pytest.approx(0.250456, abs=1e-6)
    assert annuity(0.0, 4.0) == 0.25
    money = Money(100_000.0, 2000.0, 30.0, 1.0, 4.0, 0.05, 10.0)
    found = earnings(money, 20.0, 25.0)
    # 40,000 pieces for 160,000, of 50,000 that were begun and 2000 hours of 30: 110,000.
    assert found.surplus == pytest.approx(50_000.0)
    assert found.payback == pytest.approx(2.0)
    assert found.piece_cost == pytest.approx((110_000.0 + 12_950.46) / 40_000.0, abs=1e-5)
    # 7.721735, the value of ten payments at 5%, times 50,000.
    assert found.present_value == pytest.approx(7.721735 * 50_000.0 - 100_000.0, abs=0.1)
    assert (earnings(money, 0.0, 0.0).piece_cost, earnings(money, 0.0, 0.0).payback) == (None, None)


LINE = """
schema_version: 1
source: {law: expon, scale: 55}
stations:
- {name: load, cycle: 20, buffer: unlimited, price: 10000}
- name: weld
  cycle: {law: lognorm, s: 0.2, scale: cycle}
  buffer: places
  machines: welders
  failures: {between: {law: expon, scale: 4000}, repair: 200}
  scrap: 0.01
  price: 90000
- {name: check, cycle: 30, buffer: 1, price: 40000}
money: {hours: 3000, running: 60, material: 2, revenue: 5, interest: 0.06, years: 8}
"""
STUDY = """
schema_version: 1
function: virtualrobot_apps.studies.line:{function}
setup: virtualrobot_apps.studies.line_file:open_line
scene: line.yaml
draws: 3
parameters:
  hours: {{list: [8]}}
  warm_up: {{list: [1]}}
  cycle: {{list: [50]}}
  places: {{list: [0, 4]}}
  welders: {{list: [1, 2]}}
results: {{{results}}}
"""
PRODUCED = "throughput: number, lead_time: number, inside: number, scrapped: number, bottleneck: text"
EARNED = ", investment: number, piece_cost: number, surplus: number, payback: number, present_value: number"


def test_a_study_of_a_line_tells_what_more_welders_earn(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "line.yaml").write_text(LINE)
    study = written(tmp_path / "in", STUDY.format(function="earn", results=PRODUCED + EARNED))
    progress, parts = done(study, tmp_path / "out")
    assert (progress.done, progress.failed) == (12, 0), parts.table().column("error").to_pylist()
    rows = parts.table().to_pylist()
    one, two = ([row for row in rows if row["welders"] == count] for count in (1, 2))
    # 55 s between parts is more than 50 s and what repairs add, (1 + 200 / 4000) of it, only just.
    assert {row["investment"] for row in one} == {140_000.0} and {row["investment"] for row in two} == {230_000.0}
    assert np.mean([row["lead_time"] for row in two]) < np.mean([row["lead_time"] for row in one])
    assert all(row["bottleneck"] == "weld" for row in one)
    for row in rows:
        begun = row["throughput"] + row["scrapped"]
        surplus = 3000.0 * (5.0 * row["throughput"] - 60.0 - 2.0 * begun)
        assert row["surplus"] == pytest.approx(surplus)
        assert row["payback"] == pytest.approx(row["investment"] / surplus)
    plain = done(written(tmp_path / "in", STUDY.format(function="produce", results=PRODUCED)), tmp_path / "plain")[1]
    assert plain.table().column("throughput").equals(parts.table().column("throughput"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("cycle: 20", "cycle: 0", "line.yaml:5: stations[0].cycle: a number from 1e-06 to 1e+15 belongs here, not 0"),
        ("cycle: 20", "cycle: cycl", "the study has no parameter 'cycl'; did you mean 'cycle'?"),
        ("cycle: 20", "cycle: {scale: 3}", "a time (s) belongs here, or a law"),
        ("name: load", "name: weld", "'weld' is the name of two stations"),
        ("name: load", "name: source", "'source' is the name of parts come from"),
        ("lognorm, s: 0.2", "lognorm", "the law 'lognorm' needs 's'"),
        ("scrap: 0.01", "scrap: 2", "a number from 0 to 1 belongs here, not 2"),
        ("machines: welders", "machines: 1.5", "a whole number belongs here, not 1.5"),
        ("price: 40000", "prize: 40000", "there is no field 'prize'; did you mean 'price'?"),
        ("years: 8", "years: 0", "a number from 0.1 to 1000 belongs here, not 0"),
        ("buffer: places", "buffer: many", "the study has no parameter 'many'"),
    ],
)
def test_lines_that_are_none_are_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "line.yaml").write_text(LINE.replace(old, new))
    with pytest.raises(MalformedFileError, match=re.escape(said)):
        LineFile(tmp_path / "line.yaml").line({"cycle": 50.0, "places": 2, "welders": 1})


def test_bad_input_is_told(tmp_path: Path) -> None:
    with pytest.raises(InvalidArgumentError, match="this study needs a line"):
        open_line(None)
    with pytest.raises(MissingFileError, match=r"none.yaml cannot be read"):
        open_line(tmp_path / "none.yaml")
    (tmp_path / "line.yaml").write_text(LINE)
    file = LineFile(tmp_path / "line.yaml")
    with pytest.raises(MalformedFileError, match=r"belongs here, not -1 of the parameter 'welders'"):
        file.line({"cycle": 50.0, "places": 2, "welders": -1})
    with pytest.raises(MalformedFileError, match=r"belongs here, not 'a' of the parameter 'cycle'"):
        file.line({"cycle": "a", "places": 2, "welders": 1})
    with pytest.raises(ValueError, match=r"the law 'norm' gives -.* s for the cycle of 'a': take one that gives times"):
        flow([Station("a", Law("", "norm", (("loc", -1.0),)))], np.random.default_rng(1), 100.0)
    with pytest.raises(ValueError, match="a chart ends after it begins"):
        gantt([], 1.0, 1.0)


def test_a_chart_has_a_row_for_each_machine_and_a_bar_for_each_spell() -> None:
    """10 s at a, then 20 s at b without a place between: in the first minute b has parts from 10 s on."""
    found = flow([Station("a<1>", 10.0), Station("b", 20.0)], np.random.default_rng(1), 60.0, kept=60.0)
    chart = gantt(found.spells, 0.0, 60.0)
    titles = re.findall(r"<title>(.*?)</title>", chart)
    assert titles[:4] == [
        "work, part 0: 0.0 s to 10.0 s",
        "work, part 0: 10.0 s to 30.0 s",
        "work, part 1: 10.0 s to 20.0 s",
        "blocked, part 1: 20.0 s to 30.0 s",
    ]
    assert "a&lt;1&gt;</text>" in chart and ">b</text>" in chart
    # 660 points are 60 s: the first bar is a sixth of that.
    assert 'x="140.00" y="0" width="110.00"' in chart
    twins = flow([Station("a", 10.0, machines=2)], np.random.default_rng(1), 60.0, kept=60.0)
    assert re.findall(r">(a \d)</text>", gantt(twins.spells, 0.0, 60.0)) == ["a 1", "a 2"]
