"""Who is told what happens."""

from __future__ import annotations

from virtualrobot_kernel.world.listeners import Listeners


def test_each_is_told_until_it_ends_also_the_same_one_twice() -> None:
    told: list[int] = []
    listeners: Listeners[[int]] = Listeners()
    assert not listeners
    ends = [listeners.add(told.append), listeners.add(told.append), listeners.add(lambda value: told.append(-value))]
    assert listeners
    listeners.tell(1)
    assert told == [1, 1, -1]
    ends[0]()
    ends[0]()
    listeners.tell(2)
    assert told[3:] == [2, -2]
    for end in ends:
        end()
    listeners.tell(3)
    assert len(told) == 5 and not listeners


def test_one_may_end_itself_while_all_are_told() -> None:
    told: list[str] = []
    listeners: Listeners[[]] = Listeners()

    def once() -> None:
        told.append("once")
        end()

    end = listeners.add(once)
    listeners.add(lambda: told.append("always"))
    listeners.tell()
    listeners.tell()
    assert told == ["once", "always", "always"]
