"""Addresses and tokens."""

from __future__ import annotations

import os
import traceback
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
    assert session.find_token(1234)[0] == ""
    (tmp_path / "token-1234").write_text("of-the-user\n")
    assert session.find_token(1234) == ("of-the-user", f"the file {tmp_path / 'token-1234'}")
    assert session.find_token(1235)[0] == ""
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", "of-the-environment\n")
    assert session.find_token(1234) == ("of-the-environment", "VIRTUALROBOT_TOKEN")
    (given := tmp_path / "given").write_text("of-the-option")
    assert session.find_token(1234, given) == ("of-the-option", f"the file {given}")


@pytest.mark.parametrize(
    ("variable", "file", "said"),
    [
        (
            __file__,
            None,
            "VIRTUALROBOT_TOKEN is the token itself, and what it holds is the path of a file; --token-file",
        ),
        (f"{Path(__file__).parent}/tokne", None, "VIRTUALROBOT_TOKEN is the token itself, and what it holds is the"),
        ("~/.local/state/virtualrobot/token-1", None, "is the path of a file; --token-file and token_file take files"),
        ("./tokne", None, "is the path of a file"),
        ("two words", None, "VIRTUALROBOT_TOKEN holds no token: a token is one word"),
        ("geheim\N{LATIN SMALL LETTER U WITH DIAERESIS}", None, "VIRTUALROBOT_TOKEN holds no token"),
        (
            "",
            "Zm9vYmFyYmF6",
            "the file of the name .* in .*: No such file.*; a token itself goes into VIRTUALROBOT_TOKEN",
        ),
        ("", "Zm9v/mFyYmF6==", "the file of the name that was given, in"),
        ("", "/tmp/tokne", "the file '/tmp/tokne': No such file"),
        ("", "/tmp/..", "file '/tmp/..': Is a directory"),
        ("", os.devnull, "is empty"),
    ],
)
def test_a_path_for_a_token_and_a_token_for_a_path_are_told(
    monkeypatch: pytest.MonkeyPatch, variable: str, file: str | None, said: str
) -> None:
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", variable)
    with pytest.raises(ValueError, match=said) as refused:
        session.given_token(None if file is None else Path(file))
    for secret in ("Zm9v", "geheim", "two words", "tokne") if file is None or file[0] == "Z" else ():
        assert secret not in "".join(traceback.format_exception(refused.value)).replace(__file__, "")


@pytest.mark.parametrize("token", ["dG9r/2Vu+g==", "/9j/4AAQ+SkZ", "a.b.c", "token", "x" * 5000])
def test_a_token_may_look_somewhat_like_a_path(token: str) -> None:
    assert session.checked_token(token, "it") == token


def test_each_port_has_a_token_of_its_own() -> None:
    assert session.token_path(1).name == "token-1"
    assert session.token_path(1) != session.token_path(2)
