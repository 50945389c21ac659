"""Tokens: they outlive the kernel in their file, which tells none of them, and nothing is half done."""

from __future__ import annotations

import json
import logging
import os
import stat
import sys
from pathlib import Path

import pytest
from virtualrobot_kernel.api.roles import refused
from virtualrobot_kernel.api.token_table import KERNEL, Account, Role, TokenTable
from virtualrobot_kernel.errors import KernelError, Reason


def test_tokens_are_found_again_after_a_restart(tmp_path: Path) -> None:
    file = tmp_path / "tokens.json"
    table = TokenTable("own", file)
    account, secret = table.create("panel", Role.OPERATOR, "ada")
    table.create("wall", Role.OBSERVER, "ada")
    again = TokenTable("another own", file)
    assert again.accounts == table.accounts
    assert again.find(secret.encode()) == account
    assert again.find(b"own") is None
    assert again.find(b"another own") is KERNEL
    again.revoke("panel")
    assert TokenTable("own", file).find(secret.encode()) is None
    assert [one.name for one in TokenTable("own", file).accounts] == ["wall"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no file modes")
def test_the_file_tells_no_token_and_is_for_its_user_alone(tmp_path: Path) -> None:
    file = tmp_path / "tokens.json"
    _, secret = TokenTable("own", file).create("panel", Role.OPERATOR, "ada")
    assert secret not in file.read_text() and "own" not in file.read_text()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert os.listdir(tmp_path) == ["tokens.json"]


def test_what_cannot_be_written_has_not_happened(tmp_path: Path) -> None:
    table = TokenTable("own", tmp_path / "tokens.json")
    _, secret = table.create("panel", Role.OPERATOR, "ada")
    (tmp_path / "tokens.json").unlink()
    tmp_path.rmdir()
    for change in (lambda: table.create("other", Role.ADMIN, "ada"), lambda: table.revoke("panel")):
        with pytest.raises(KernelError, match="nothing has changed") as error:
            change()
        assert error.value.reason is Reason.WRONG_STATE
    assert [one.name for one in table.accounts] == ["panel"]
    assert table.find(secret.encode())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is no table of tokens"),
        ("[]", "is no table of tokens"),
        ('{"version": 2, "tokens": []}', "of version 2; this kernel reads version 1"),
        ('{"version": 1, "tokens": [{"name": "a"}]}', "is no table of tokens"),
        (
            '{"version": 1, "tokens": [{"name": "a", "role": "KING", "sha256": "", "created": 1, "by": ""}]}',
            "no table",
        ),
        ("\x00\xff", "is no table of tokens"),
    ],
)
def test_a_file_that_is_none_is_refused_and_stays(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "tokens.json"
    file.write_text(text, "latin-1")
    with pytest.raises(KernelError, match=said) as error:
        TokenTable("own", file)
    assert error.value.reason is Reason.MALFORMED_FILE
    assert file.read_text("latin-1") == text


def test_an_empty_sha256_in_the_file_lets_nobody_in(tmp_path: Path) -> None:
    """An entry that somebody has spoilt is no open door: no token has such a SHA-256."""
    one = {"name": "a", "role": "ADMIN", "sha256": "", "created": 1, "by": ""}
    (tmp_path / "t").write_text(json.dumps({"version": 1, "tokens": [one]}))
    assert TokenTable("own", tmp_path / "t").find(b"") is None


def test_refusals_by_role_are_logged_once_for_each_token_and_kind(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        for name in ("wall", "wall", "panel", "wall"):
            for what in ("StepClock", "Apply"):
                refused(what, Role.OPERATOR, Account(name, Role.OBSERVER))
    said = [record.getMessage() for record in caplog.records]
    assert said == [
        f"refused: {what} needs the role 'operator'; the token {name!r} is an observer's"
        for name in ("wall", "panel")
        for what in ("StepClock", "Apply")
    ]
