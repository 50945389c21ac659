"""URScript at work: values, scopes, threads and time, by the rules of the manual, and its functions by their formulas.

The manual is Universal Robots' "The URScript Programming Language"; nothing here moves a robot.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_apps.languages.urscript import task as at_work
from virtualrobot_apps.languages.urscript.table import BUILTINS
from virtualrobot_apps.languages.urscript.values import Pose

from tests.apps.languages.urscript import said, stopped, written


def called(name: str, *arguments: object) -> object:
    """Return what a function of the language says."""
    return BUILTINS[name].run(None, *arguments)


def test_operators_bind_as_in_python_and_a_quotient_is_no_whole_number() -> None:
    assert said(
        """
        textmsg(1 + 2 * 3 - 4 / 8)
        textmsg(-2 * -(3 - 5) + 7 % 4)
        textmsg(True or False and False xor True)
        textmsg(not 42 >= 87 and 87 <= 42)
        textmsg(not 1 == 2)
        textmsg("a" + "b" == "ab")
        textmsg(0x1F + 1e2 + .5)
        textmsg(7 / 2)
        """
    ) == ["6.5", "-1", "False", "False", "True", "True", "131.5", "3.5"]


def test_lists_are_computed_element_by_element() -> None:
    assert said(
        """
        a = [1, 2, 3]
        textmsg(2 * a + a / 2 - -a * 3)
        m = [[1, 2], [3, 4]]
        m[1, 0] = 9
        textmsg(m[1][0] + m[0, 1])
        """
    ) == ["[5.5, 11, 16.5]", "11"]


def test_lists_poses_and_structs_are_values() -> None:
    """A value that is assigned, given to a function or returned from a variable is a copy."""
    assert said(
        """
        def changed(list):
          list[0] = 9
          return list
        end
        a = [1, 2]
        b = a
        b[0] = 5
        c = changed(a)
        s = struct(name="x", values=a)
        s.values[1] = 7
        t = s
        t.name = "y"
        textmsg(a, b)
        textmsg(c, s)
        textmsg(t.name, s.values)
        """
    ) == ["[1, 2][5, 2]", "[9, 2]struct(name=x, values=[1, 7])", "y[1, 7]"]


def test_scopes_are_those_of_the_manual() -> None:
    """Its cases: a local one, the global one, one global for nested functions, the first level of a program."""
    assert said(
        """
        a = 0
        def own():
          local a = 1
          def inner():
            a = a + 10
          end
          inner()
          return a
        end
        def shared():
          a = a + 100
          b = a
          global c = b
        end
        r = own()
        shared()
        textmsg(r, a)
        textmsg(c)
        """
    ) == ["1110", "110"]


def test_arguments_have_names_and_values_of_their_own() -> None:
    assert said(
        """
        start = 5
        def f(a, b=start, c=[1]):
          c[0] = c[0] + 1
          return [a, b, c[0]]
        end
        textmsg(f(1), f(c=[7], a=2))
        start = 6
        textmsg(f(3))
        """
    ) == ["[1, 5, 2][2, 5, 8]", "[3, 6, 2]"]


def test_loops_branches_and_halt() -> None:
    assert said(
        """
        i = 0
        while True:
          i = i + 1
          if i == 2:
            continue
          elif i > 4:
            break
          else:
            textmsg(i)
          end
        end
        if i and not (i < 5): textmsg("five") end
        halt
        textmsg("never")
        """
    ) == ["1", "3", "4", "five"]


def test_threads_take_turns_where_they_wait() -> None:
    assert said(
        """
        n = 0
        thread count():
          while n < 3:
            n = n + 1
            textmsg("thread ", n)
            sync()
          end
          return 0
        end
        handle = run count()
        while n < 2:
          textmsg("main ", n)
          sync()
        end
        join handle
        textmsg("joined ", n)
        """
    ) == ["main 0", "thread 1", "main 1", "thread 2", "thread 3", "joined 3"]


def test_a_thread_is_killed_where_it_waits_and_all_end_with_the_program() -> None:
    assert said(
        """
        thread one():
          while True:
            sleep(0.01)
            textmsg("one")
          end
        end
        thread two():
          sleep(0.02)
          textmsg("two")
          kill itself
          textmsg("never")
        end
        none = 0
        kill none
        join none
        handle = run one()
        itself = run two()
        sleep(0.015)
        kill handle
        textmsg(handle != 0)
        sleep(0.02)
        """
    ) == ["one", "True", "two"]


def test_sections_let_nobody_in_between() -> None:
    """As on a controller, where only a wait gives another thread its turn."""
    assert said(
        """
        a = 0
        b = 0
        thread other():
          while True:
            enter_critical
            a = a + 1
            b = b + 1
            exit_critical
            sync()
          end
        end
        handle = run other()
        i = 0
        same = True
        while i < 100:
          enter_critical
          same = same and a == b
          exit_critical
          i = i + 1
          sync()
        end
        textmsg(same, a)
        """
    ) == ["True100"]


def test_time_is_counted_in_cycles() -> None:
    task = at_work.ScriptTask(at_work.load("sleep(0.1)\nsync()\n"), dt=0.002)
    cycles = 1
    while task.cycle():
        cycles += 1
    assert cycles == 0.1 / 0.002 + 1 + 1


def test_a_thread_that_never_waits_lets_others_run_and_ends_the_script() -> None:
    fault = stopped(
        """
        thread spin():
          while True:
            pass
          end
        end
        handle = run spin()
        i = 0
        while i < 3:
          i = i + 1
          sync()
        end
        textmsg("done")
        join handle
        """
    )
    assert fault == "test.script:2: 'spin' computes without a wait: put sync() or sleep() into its loop"


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ("a = [1]\ntextmsg(a[1])", "3: the index 1 is outside 0 to 0"),
        ("a = [1]\na[0.5] = 1", "3: an index is a whole number, not 0.5"),
        ("a = 1\ntextmsg(a[0])", "3: a number has no elements"),
        ('a = "x" + 1', "2: '+' can't take a string and a number"),
        ("a = [1] + [1, 2]", "2: '+' takes lists of one length, not of 1 and 2"),
        ("a = p[0, 0, 0, 0, 0, 0] * 2", "2: '*' can't take a pose and a number"),
        ('if "x":\n  pass\nend', "2: a condition is True or False, not a string"),
        ("a = 1 < True", "2: '<' can't take a number and a truth"),
        ("a = 1 / 0", "2: a division by zero"),
        ("a = sqrt(-1)", "2: this can't be computed: math domain error"),
        ("a = pow(10, 400)", "2: this can't be computed: math range error"),
        ('a = sin("x")', "2: f is a number, not a string"),
        ("if False:\n  a = 1\nend\ntextmsg(a)", "5: 'a' has no value yet"),
        ("def f():\n  if False:\n    b = 1\n  end\n  return b\nend\nf()", "6: 'b' has no value yet"),
        ("def f():\n  f()\nend\nf()", "3: functions call each other too deeply"),
        ("a = p[1, 2, 3, 4, 5, True]", "2: a pose has numbers alone, and this is a truth: True"),
        (
            "a = [1, 2]\nwhile True:\n  a = [a, a]\nend",
            "4: a list has at most 10000 elements, those of the lists in it included",
        ),
        ('a = "ab"\nwhile True:\n  a = a + a\nend', "4: a string has at most 1048576 characters"),
        ("s = struct(a=1)\ns.b = 1", "3: this struct has no component 'b'; it has a"),
        ("sleep(-1)", "2: t is 0 or more seconds, not -1"),
        ('a = to_num("1x")', "2: '1x' is no number"),
        (
            "thread t():\n  sync()\nend\nwhile True:\n  h = run t()\nend",
            "6: there can't be more than 100 threads at the same time",
        ),
    ],
)
def test_faults_while_it_runs_name_the_line(statements: str, expected: str) -> None:
    assert stopped(f"def tried():\n{statements}\nend") == f"test.script:{expected}"


def test_arithmetic_is_that_of_its_formulas() -> None:
    assert called("atan2", 0.5, -1.0) == pytest.approx(math.atan(0.5 / -1.0) + math.pi)
    assert called("log", 2.0, 8.0) == pytest.approx(3.0)
    assert called("d2r", 180.0) == pytest.approx(math.pi) and called("r2d", math.pi) == pytest.approx(180.0)
    assert called("norm", [3, 4]) == pytest.approx(5.0) and called("norm", -2) == 2
    assert called("normalize", [3, 0, 4]) == pytest.approx([0.6, 0.0, 0.8])
    assert called("size", [[1, 2, 3], [4, 5, 6]]) == [2, 3] and called("get_list_length", [1, 2]) == 2
    for value in (-(2**31), -1, 0, 5, 2**31 - 1):
        assert called("binary_list_to_integer", called("integer_to_binary_list", value)) == value
    assert called("binary_list_to_integer", [True, False, True]) == 5


def test_poses_obey_the_laws_of_rigid_motions(rng: np.random.Generator) -> None:
    def drawn() -> Pose:
        return Pose(rng.uniform(-1.5, 1.5, 6).tolist())

    def same(one: object, other: object) -> None:
        np.testing.assert_allclose(np.array(one, dtype=float), np.array(other, dtype=float), atol=1e-9)

    for _ in range(20):
        a, b, c = drawn(), drawn(), drawn()
        left = called("pose_trans", called("pose_trans", a, b), c)
        same(left, called("pose_trans", a, called("pose_trans", b, c)))
        same(called("pose_trans", a, called("pose_inv", a)), [0.0] * 6)
        added = called("pose_add", a, b)
        assert isinstance(added, Pose)
        same(added[:3], np.add(a[:3], b[:3]))
        same(added[3:], called("pose_trans", [0, 0, 0, *a[3:]], [0, 0, 0, *b[3:]])[3:])  # type: ignore[index]
        same(called("interpolate_pose", a, b, 0), a)
        same(called("interpolate_pose", a, b, 1), b)
        assert called("point_dist", a, b) == pytest.approx(np.linalg.norm(np.subtract(a[:3], b[:3])))
        same(called("rpy2rotvec", called("rotvec2rpy", a[3:])), a[3:])
    same(called("rpy2rotvec", [0.0, math.pi / 2, 0.0]), [0.0, math.pi / 2, 0.0])
    same(called("rpy2rotvec", called("rotvec2rpy", [0.0, math.pi / 2, 0.0])), [0.0, math.pi / 2, 0.0])


def test_strings_are_cut_and_joined() -> None:
    assert called("str_cat", "a", [1, 2.5]) == "a[1, 2.5]"
    assert (called("str_len", "abc"), called("str_empty", ""), called("str_at", "abc", 1)) == (3, True, "b")
    assert (called("str_sub", "hello", 1, 3), called("str_sub", "hello", 2, None)) == ("ell", "llo")
    assert (called("str_find", "banana", "na", 3), called("str_find", "banana", "x", 0)) == (4, -1)
    assert (called("to_num", "-12"), called("to_num", " 1e3 "), called("to_num", "0x10")) == (-12, 1000.0, 16)
    assert (called("to_str", p := Pose([1, 2, 3, 0, 0, 0.5])), p) == ("p[1, 2, 3, 0, 0, 0.5]", p)


def test_lines_alone_are_a_program() -> None:
    assert written('textmsg("one")\nsleep(0.01)\ntextmsg("two")') == ["one", "two"]
