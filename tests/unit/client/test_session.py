"""Addresses and tokens."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot import session


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("example.org:1234", ("example.org", 1234)),
        ("example.org", ("example.org", 50500)),
        (":1234", ("127.0.0.1", 1234)),
        ("", ("127.0.0.1", 50500)),
        ("[::1]:1234", ("::1", 1234)),
        ("[::1]", ("::1", 50500)),
        ("::1", ("::1", 50500)),
    ],
)
def test_addresses(address: str, expected: tuple[str, int]) -> None:
    assert session.split_address(address) == expected


@pytest.mark.parametrize("address", ["host:port", "host:0", "host:65536", "host:-1", "host:1.5", "host:٣"])
def test_bad_ports_are_refused(address: str) -> None:
    with pytest.raises(ValueError, match="is no port"):
        session.split_address(address)


def test_the_token_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("VIRTUALROBOT_TOKEN", raising=False)
    monkeypatch.setattr(session, "token_path", lambda port: tmp_path / f"token-{port}")
    assert session.find_token(1234) is None
    (tmp_path / "token-1234").write_text("from the file\n")
    assert session.find_token(1234) == "from the file"
    assert session.find_token(1235) is None
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", "from the environment")
    assert session.find_token(1234) == "from the environment"


def test_each_port_has_a_token_of_its_own() -> None:
    assert session.token_path(1).name == "token-1"
    assert session.token_path(1) != session.token_path(2)
