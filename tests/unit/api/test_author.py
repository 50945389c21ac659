"""Authors: the journal tells by which token somebody was let in, whatever he calls himself."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from virtualrobot_kernel.api.author import author, is_mine, person
from virtualrobot_kernel.api.token_table import CALLER, KERNEL, Account, Role


class Call:
    """Stands for the context of a call."""

    def __init__(self, name: str | None = None, port: int = 1) -> None:
        """Call under a name, from a port."""
        self._name, self._port = name, port

    def invocation_metadata(self) -> tuple[tuple[str, str], ...]:
        return () if self._name is None else (("client-name", self._name),)

    def peer(self) -> str:
        return f"ipv4:127.0.0.1:{self._port}"


@pytest.fixture
def panel() -> Iterator[None]:
    """Be called with the token `panel`."""
    reset = CALLER.set(Account("panel", Role.OPERATOR))
    yield
    CALLER.reset(reset)


def test_the_name_of_the_token_stands_first(panel: None) -> None:
    assert author(Call("cell.py")) == "panel with cell.py at ipv4:127.0.0.1:1"
    assert person(Call()) == "panel with client at ipv4:127.0.0.1"
    assert author(Call("wall with cell.py")).startswith("panel with wall with ")


def test_nobody_gives_himself_the_name_of_a_token() -> None:
    assert CALLER.get() is KERNEL
    assert author(Call("panel with cell.py")) == "panel cell.py at ipv4:127.0.0.1:1"


def test_what_is_mine_is_of_the_same_token(panel: None) -> None:
    mine = is_mine(Call("cell.py"))
    assert mine(author(Call("cell.py", port=2)))
    assert not mine("wall with cell.py at ipv4:127.0.0.1:1")
    assert not mine("cell.py at ipv4:127.0.0.1:1")
