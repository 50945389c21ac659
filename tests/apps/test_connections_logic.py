"""Logic of connections without a kernel: operators against the definitions of IEC 61131-3, order, loops, and files."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.connections.expressions import Value
from virtualrobot_apps.connections.file import ConnectionFile, connections_of
from virtualrobot_apps.connections.logic import Logic, Result

TICK = 0.004
WORLD: dict[str, Value] = {
    **{name: False for name in ("a", "b", "c", "x", "y", "z")},
    **{"n": 0, "m": 0, "level": 0.0, "limit": 5.0, "word": "", "bus": (False, True, False), "lines": (False, False)},
}


def file_of(connections: str, more: str = "") -> ConnectionFile:
    """Return a file with these lines below `connections`."""
    lines = "".join(f"  {line}\n" for line in connections.strip().splitlines())
    return connections_of(parse(f"schema_version: 1\n{more}connections:\n{lines}", "cell-io.yaml"))


def logic_of(connections: str, **values: Value) -> Logic:
    """Return the logic of these lines in a world with these values."""
    file = file_of(connections)
    world = WORLD | values
    file.check_signals(world)
    return Logic(file.connections, TICK, world, 0)


def trace(logic: Logic, name: str, inputs: Mapping[int, Mapping[str, Value]], until: int) -> list[tuple[int, Value]]:
    """Return when the signal `name` has changed to what."""
    results = [one for tick in sorted({0, until, *inputs}) for one in logic.advance(tick, inputs.get(tick, {}))]
    return [(one.tick, one.values[name]) for one in results if name in one.values]


@pytest.mark.parametrize(("operator", "table"), [("and", "0001"), ("or", "0111"), ("xor", "0110")])
def test_truth_tables(operator: str, table: str) -> None:
    logic = logic_of(f"x: {{{operator}: [a, b]}}")
    for case, wanted in enumerate(table):
        logic.advance(case, {"a": case >= 2, "b": case % 2 == 1})
        assert logic.driven_values["x"] is (wanted == "1")


def test_not_and_what_depends_on_what_is_driven() -> None:
    """Each comes after those that it depends on, whatever their order in the file."""
    logic = logic_of("x: {not: y}\ny: {and: [z, a]}\nz: {or: [b, c]}")
    assert logic.advance(1, {}) == [Result(1, {"x": True})]
    assert logic.advance(2, {"a": True, "c": True}) == [Result(2, {"z": True, "y": True, "x": False})]


def test_edges_last_one_tick() -> None:
    on_off = {10: {"a": True}, 20: {"a": False}}
    assert trace(logic_of("x: {rising: a}"), "x", on_off, 30) == [(10, True), (11, False)]
    assert trace(logic_of("x: {falling: a}"), "x", on_off, 30) == [(20, True), (21, False)]
    assert trace(logic_of("x: {rising: a}", a=True), "x", {}, 30) == [], "what is on from the start has no edge"
    assert trace(logic_of("x: {falling: a}"), "x", {}, 30) == []


def test_delay_on_is_ton() -> None:
    """Timer on delay: ten ticks after the input, and never where that is on for less."""
    inputs = {5: {"a": True}, 10: {"a": False}, 20: {"a": True}, 50: {"a": False}}
    assert trace(logic_of("x: {delay_on: {input: a, seconds: 0.04}}"), "x", inputs, 60) == [(30, True), (50, False)]


def test_delay_off_is_tof() -> None:
    inputs = {5: {"a": True}, 10: {"a": False}, 15: {"a": True}, 20: {"a": False}}
    logic = logic_of("x: {delay_off: {input: a, seconds: 0.04}}")
    assert trace(logic, "x", inputs, 60) == [(5, True), (30, False)]
    assert trace(logic_of("x: {delay_off: {input: a, seconds: 0.04}}"), "x", {}, 60) == []


def test_pulse_is_tp() -> None:
    """A pulse has its length, whether its input is shorter, longer or comes again meanwhile."""
    inputs = {5: {"a": True}, 7: {"a": False}, 9: {"a": True}, 40: {"a": False}, 50: {"a": True}}
    logic = logic_of("x: {pulse: {input: a, seconds: 0.04}}")
    assert trace(logic, "x", inputs, 100) == [(5, True), (15, False), (50, True), (60, False)]


def test_seconds_are_rounded_up_to_ticks() -> None:
    assert trace(logic_of("x: {pulse: {input: a, seconds: 0.041}}"), "x", {5: {"a": True}}, 99)[1] == (16, False)
    assert trace(logic_of("x: {pulse: {input: a, seconds: 0}}"), "x", {5: {"a": True}}, 99)[1] == (6, False)


def test_set_reset_keeps_its_state_and_reset_wins() -> None:
    logic = logic_of("x: {set_reset: {set: a, reset: b}}")
    inputs = {1: {"a": True}, 2: {"a": False}, 3: {"b": True}, 4: {"a": True}, 5: {"b": False}}
    assert trace(logic, "x", inputs, 9) == [(1, True), (3, False), (5, True)]
    goes_on = logic_of("x: {set_reset: {set: a, reset: b}}", x=True)
    assert goes_on.advance(1, {}) == [], "it begins with the value that the signal has"


def test_counters_count_edges_up_and_down() -> None:
    logic = logic_of("n: {count: {up: a, down: b, reset: c}}", n=3)
    inputs: dict[int, dict[str, Value]] = {
        **{tick: {"a": tick % 2 == 1} for tick in range(1, 7)},
        **{7: {"b": True}, 8: {"c": True}, 9: {"c": False, "b": False}},
    }
    assert trace(logic, "n", inputs, 10) == [(1, 4), (3, 5), (5, 6), (7, 5), (8, 0)]


def test_numbers_are_compared_and_chosen() -> None:
    logic = logic_of("x: {at_least: [level, limit]}\nm: {choose: {when: x, then: 7, otherwise: n}}")
    assert logic.advance(1, {"level": 4.9, "n": 2}) == [Result(1, {"m": 2})]
    assert logic.advance(2, {"level": 5.0}) == [Result(2, {"x": True, "m": 7})]
    assert logic_of('x: {equal: [word, {text: "open"}]}').advance(1, {"word": "open"}) == [Result(1, {"x": True})]
    (given,) = logic_of("level: {choose: {when: a, then: 1, otherwise: 2}}").advance(1, {})
    assert given.values == {"level": 2.0} and isinstance(given.values["level"], float)


def test_groups_are_taken_apart_and_made() -> None:
    logic = logic_of("x: {bit: {of: bus, index: 1}}\nlines: {group: [a, {not: a}]}")
    assert logic.advance(1, {}) == [Result(1, {"x": True, "lines": (False, True)})]


def test_what_runs_out_between_two_changes_has_its_own_tick() -> None:
    """Of a client that hears late, each result still tells when it was, in order."""
    logic = logic_of(
        "x: {pulse: {input: a, seconds: 0.02}}\nn: {count: {up: x}}\ny: {delay_on: {input: x, seconds: 0.012}}"
    )
    logic.advance(0, {})
    results = logic.advance(10, {"a": True}) + logic.advance(100, {"a": False})
    assert results == [Result(10, {"x": True, "n": 1}), Result(13, {"y": True}), Result(15, {"x": False, "y": False})]


def test_a_late_change_counts_at_the_latest_tick() -> None:
    logic = logic_of("x: a")
    logic.advance(50, {})
    assert logic.advance(40, {"a": True}) == [Result(50, {"x": True})]


def test_equal_changes_give_equal_results(rng: np.random.Generator) -> None:
    """Whoever tells all at once, or asks at each tick, gets the same values at the same ticks."""
    text = """
x: {delay_on: {input: {xor: [a, b]}, seconds: 0.02}}
y: {delay_off: {input: {pulse: {input: c, seconds: 0.03}}, seconds: 0.012}}
n: {count: {up: {and: [x, {not: y}]}, down: {falling: y}}}
"""
    ticks = np.flatnonzero(rng.random(2000) < 0.1)
    changes = {int(tick): {str(rng.choice(["a", "b", "c"])): bool(rng.random() < 0.5)} for tick in ticks}
    seldom, often = logic_of(text), logic_of(text)
    late = [one for tick in sorted(changes) for one in seldom.advance(tick, changes[tick])] + seldom.advance(2100, {})
    each = [one for tick in range(2101) for one in often.advance(tick, changes.get(tick, {}))]
    assert late == each
    assert len(each) > 20


@pytest.mark.parametrize(
    ("connections", "said"),
    [
        ("x: {and: [a, q]}", "cell-io.yaml:3: connections.x.and[1]: there is no signal 'q'"),
        ("x: {and: [a, worde]}", "did you mean 'word'?"),
        ("x: {adn: [a, b]}", "there is no operator 'adn'; did you mean 'and'?"),
        ("x: [a, b]", "a list needs an operator before it: one of and, or"),
        ("x: {and: [a]}", "'and' takes two or more, not 1"),
        ("x: {less: [n, m, n]}", "'less' takes two, not 3"),
        ("x: {and: [a, n]}", "connections.x.and[1]: the signal 'n' is integer, and boolean is wanted: a comparison"),
        ("x: {less: [n, word]}", "'less' can't compare integer with text"),
        ("x: {less: [a, b]}", "'less' can't compare boolean with boolean"),
        ("x: n", "'x' is boolean, and this gives integer"),
        ("n: level", "'n' is integer, and this gives number"),
        ("x: {delay_on: {input: a, seconds: -1}}", "a number from 0 to 86400 belongs here, not -1"),
        ("x: {delay_on: {input: a, seconds: .nan}}", "a finite number"),
        ("x: {delay_on: {input: a, second: 1}}", "there is no field 'second'; did you mean 'seconds'?"),
        ("x: {delay_on: {input: a}}", "the field 'seconds' is missing"),
        ("n: {count: {reset: a}}", "'count' needs 'up', 'down' or both"),
        ("x: {choose: {when: a, then: n, otherwise: b}}", "'then' is integer and 'otherwise' boolean"),
        ("x: {bit: {of: bus, index: 2000}}", "a whole number from 0 to 1023"),
        ("x: {not: a, and: [a, b]}", "one operator belongs here, not 2: not, and"),
        ("x: a\ny: b\nx: c", "cell-io.yaml:5: connections.x: 'x' stands here twice, first in line 3"),
        ("x: {or: [x, a]}", "a loop: 'x' <- 'x'; what has to keep its state is a 'set_reset'"),
        ("x: y\ny: {not: z}\nz: {and: [a, x]}", "a loop: 'x' <- 'y' <- 'z' <- 'x'"),
        ("x: &one a\ny: *one", "aliases (*name) are not read"),
        ("x: {and: [a, b}", "cell-io.yaml:3: not YAML"),
    ],
)
def test_a_fault_is_told_with_its_line(connections: str, said: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        file_of(connections).check_signals(WORLD)
    assert said in str(refused.value)
    assert str(refused.value).startswith("cell-io.yaml:")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("conections: {}\n", "there is no field 'conections'; did you mean 'connections'?"),
        ("signals: [{name: q}, {name: q}]\n", "the signal 'q' is made in line 2 already"),
        ("signals: [{name: a, type: integer}]\n", "'a': the world has it as boolean, not integer"),
        ("signals: [{name: q, type: whole}]\n", "'whole' is not known; it is one of boolean, integer, number, text"),
        ("tools: [{robot: r, signal: a, on: closed, off: open, done: x}]\n", "'x' is driven in line 4 already"),
        ("tools: [{robot: r, signal: n, on: closed, off: open}]\n", "the signal 'n' is integer, and boolean is wanted"),
        (
            "belts: [{robot: r, joint: j, signal: b, velocity: c}]\n",
            "the signal 'c' is boolean, and a number is wanted",
        ),
    ],
)
def test_a_fault_beside_the_connections_is_told_with_its_line(more: str, said: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        file_of("x: a", more).check_signals(WORLD)
    assert said in str(refused.value)


@pytest.mark.parametrize("text", ["", "- a", "schema_version: 2", "connections: {}", "schema_version: 1\nx: 1"])
def test_what_is_no_such_file_is_refused(text: str) -> None:
    with pytest.raises(MalformedFileError):
        connections_of(parse(text, "cell-io.yaml"))


def test_a_chain_of_ten_thousand_is_read() -> None:
    """Signals that depend on each other in a row are no recursion of the reader's."""
    chain = "\n".join(f"s{number}: s{number + 1}" for number in range(10_000))
    file = file_of(chain)
    world: dict[str, Value] = {f"s{number}": False for number in range(10_001)}
    logic = Logic(file.connections, TICK, world, 0)
    (result,) = logic.advance(1, {"s10000": True})
    assert len(result.values) == 10_000
