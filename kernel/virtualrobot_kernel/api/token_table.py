"""Tokens beside the kernel's own: who is let in, and with which role. The API's thread alone uses the table.

A token is 32 random bytes, so its SHA-256 tells nothing of it: that is what is kept, in memory and in a file.
"""

from __future__ import annotations

import hmac
import json
import re
import secrets
import time
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass
from enum import IntEnum
from hashlib import sha256
from pathlib import Path

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.whole_files import write_whole
from virtualrobot_kernel.world.listeners import Listeners

VERSION = 1
"""Version of the file's format."""

NAME = re.compile(r"[A-Za-z0-9._-]{1,50}")
MOST_TOKENS = 1_000


class Role(IntEnum):
    """Role of a token; each may do what those before it may. Names and numbers equal the contract's."""

    OBSERVER = 1
    OPERATOR = 2
    ENGINEER = 3
    ADMIN = 4

    @property
    def word(self) -> str:
        """Return the role as people say it."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Account:
    """Token as it is kept: its name, role, SHA-256 (hexadecimal), when it was made (s since 1970) and by whom."""

    name: str
    role: Role
    sha256: str = ""
    created: float = 0.0
    created_by: str = ""

    @property
    def moves_leased_only(self) -> bool:
        """True when its calls move and change such robots only as they have leased."""
        return self.role is Role.OPERATOR


KERNEL = Account("", Role.ADMIN)
"""Account of the kernel's own token, and of everybody where none is wanted."""

CALLER: ContextVar[Account] = ContextVar("CALLER", default=KERNEL)
"""Account of the call being served."""


class TokenTable:
    """Table of tokens, kept in a file where there is one."""

    def __init__(self, own: str, file: Path | None = None) -> None:
        """Let in whoever has the kernel's `own` token ("": everybody), or one of the `file`.

        Raises:
            KernelError: when the file is not such a table, or is one of a newer version.
        """
        self._own = own.encode()
        self._file = file
        self._accounts = {account.sha256: account for account in _read(file)}
        self._listeners: Listeners[[Account]] = Listeners()

    @property
    def accounts(self) -> list[Account]:
        """Tokens, oldest first, without the kernel's own."""
        return list(self._accounts.values())

    @property
    def is_open(self) -> bool:
        """True when everybody is let in."""
        return not self._own

    def find(self, token: bytes) -> Account | None:
        """Return the account of a token; None for one that nobody has."""
        if not self._own or hmac.compare_digest(token, self._own):
            return KERNEL
        return self._accounts.get(sha256(token).hexdigest())

    def holds(self, account: Account) -> bool:
        """Return whether the token of an account is still good."""
        return account is KERNEL or account.sha256 in self._accounts

    def create(self, name: str, role: Role, creator: str) -> tuple[Account, str]:
        """Make a token; return its account and the token itself.

        Raises:
            KernelError: when the name is none or another token has it, when everybody is let in anyway, when there are
                too many, or when the file cannot be written: then there is no such token.
        """
        if self.is_open:
            raise KernelError(
                "this kernel was started with --no-token and lets everybody in; a token would keep nobody out",
                reason=Reason.WRONG_STATE,
            )
        if not NAME.fullmatch(name):
            raise KernelError(
                f"{name!r} is no name of a token; it has 1 to 50 of the characters a-z, A-Z, 0-9, '.', '_', '-'",
                name=name,
            )
        if any(account.name == name for account in self._accounts.values()):
            raise KernelError(
                f"there is a token named {name!r} already; withdraw it first, or take another name",
                reason=Reason.NAME_TAKEN,
                name=name,
            )
        if len(self._accounts) >= MOST_TOKENS:
            raise KernelError(
                f"there are {MOST_TOKENS} tokens, and there may be no more; withdraw one", reason=Reason.TOO_LARGE
            )
        token = secrets.token_urlsafe(32)
        account = Account(name, role, sha256(token.encode()).hexdigest(), time.time(), creator)
        self._keep({**self._accounts, account.sha256: account})
        return account, token

    def revoke(self, name: str) -> Account:
        """Withdraw a token, and tell who listens; return its account.

        Raises:
            KernelError: when there is none of this name, or when the file cannot be written: then it is still good.
        """
        account = next((one for one in self._accounts.values() if one.name == name), None)
        if account is None:
            raise UnknownNameError("token", name, [one.name for one in self._accounts.values()])
        self._keep({key: one for key, one in self._accounts.items() if one is not account})
        self._listeners.tell(account)
        return account

    def subscribe(self, listener: Callable[[Account], None]) -> Callable[[], None]:
        """Call `listener` with the account of each token that is withdrawn, until the returned function is called."""
        return self._listeners.add(listener)

    def _keep(self, accounts: dict[str, Account]) -> None:
        if self._file is not None:
            _write(self._file, accounts.values())
        self._accounts = accounts


def withdrawn(account: Account) -> KernelError:
    """Return the error of calls whose token was withdrawn."""
    return KernelError(
        f"the token {account.name!r} was withdrawn; ask for another one",
        reason=Reason.UNAUTHENTICATED,
        token=account.name,
    )


def role_too_low(what: str, needs: Role, account: Account, **metadata: str) -> KernelError:
    """Return the error of a call, or of a command of it, that the caller's role may not do."""
    has = f"the token {account.name!r} is {_with_article(account.role)}'s"
    return KernelError(
        f"{what} needs the role {needs.word!r}; {has}",
        reason=Reason.ROLE_TOO_LOW,
        needs=needs.word,
        has=account.role.word,
        token=account.name,
        **metadata,
    )


def _with_article(role: Role) -> str:
    return f"{'an' if role.word[0] in 'aeo' else 'a'} {role.word}"


def _read(file: Path | None) -> list[Account]:
    if file is None or not file.exists():
        return []
    try:
        table = json.loads(file.read_text("utf-8"))
        if table["version"] != VERSION:
            raise KernelError(
                f"the tokens in {file} are of version {table['version']}; this kernel reads version {VERSION}",
                reason=Reason.MALFORMED_FILE,
                file=file,
            )
        return [
            Account(str(one["name"]), Role[one["role"]], str(one["sha256"]), float(one["created"]), str(one["by"]))
            for one in table["tokens"]
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise KernelError(
            f"{file} is no table of tokens: {error}; put it right, or remove it, and with it all tokens",
            reason=Reason.MALFORMED_FILE,
            file=file,
        ) from error


def _write(file: Path, accounts: Iterable[Account]) -> None:
    """Write the file as a whole or not at all, for its user alone, and have it on the disk."""
    tokens = [
        {"name": one.name, "role": one.role.name, "sha256": one.sha256, "created": one.created, "by": one.created_by}
        for one in accounts
    ]
    text = json.dumps({"version": VERSION, "tokens": tokens}, indent=1)
    try:
        write_whole(file, text.encode(), sync=True, mode=0o600)
    except OSError as error:
        raise KernelError(
            f"the tokens cannot be written to {file}: {error.strerror or error}; nothing has changed",
            reason=Reason.WRONG_STATE,
            file=file,
        ) from error
