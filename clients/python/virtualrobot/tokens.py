"""Tokens with roles: who is let in by a kernel, and what for. Only an admin makes, lists and withdraws them."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import words_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import token_pb2

ROLES = tuple(words_of(token_pb2.Role, "ROLE_").values())
"""The roles: `observer`, `operator`, `engineer`, `admin`; each may do what those before it may."""


@shown
@dataclass(frozen=True, slots=True)
class TokenInfo:
    """A token, without what it is.

    Attributes:
        name: its name, under which the journal tells what is done with it.
        role: `observer`, `operator`, `engineer` or `admin`.
        created: when it was made, by the kernel's wall clock.
        created_by: who made it.
    """

    name: str
    role: str
    created: datetime
    created_by: str


@shown
@dataclass(frozen=True, slots=True)
class NewToken(TokenInfo):
    """A token that was just made; its secret is told here and never again.

    Attributes:
        secret: what clients connect with: `virtualrobot.connect(token=...)`.
    """

    secret: str = field(repr=False)


@checked
class Tokens:
    """The tokens of a kernel beside its own.

    Example:
        >>> secret = client.tokens.create("night-shift", "operator").secret
        >>> client.tokens.revoke("night-shift")
    """

    def __init__(self, services: Services) -> None:
        """Take the services of a connection."""
        self._services = services

    def create(self, name: str, role: str) -> NewToken:
        """Make a token and return it with its secret, which the kernel does not keep.

        Args:
            name: 1 to 50 of the characters a-z, A-Z, 0-9, `.`, `_`, `-`; none that another token has.
            role: `observer`, `operator`, `engineer` or `admin`.

        Raises:
            RoleTooLowError: when this client is no admin.
            NameTakenError: when another token has the name.
            WrongStateError: when the kernel wants no token anyway.
        """
        if role not in ROLES:
            raise InvalidArgumentError(f"{role!r} is no role; there are {', '.join(map(repr, ROLES))}")
        request = token_pb2.CreateTokenRequest(name=name, role=f"ROLE_{role.upper()}")
        answer = self._services.token.CreateToken(request)
        return NewToken(*_told(answer.token), secret=answer.secret)

    def list(self) -> list[TokenInfo]:
        """Return the tokens, oldest first, without what they are; raise RoleTooLowError for all but admins."""
        answer = self._services.token.ListTokens(token_pb2.ListTokensRequest())
        return [TokenInfo(*_told(token)) for token in answer.tokens]

    def revoke(self, name: str) -> TokenInfo:
        """Withdraw a token and return it: its calls, streams and leases end, and its leased robots stop.

        Raises:
            UnknownNameError: when there is no token of this name.
            RoleTooLowError: when this client is no admin.
        """
        answer = self._services.token.RevokeToken(token_pb2.RevokeTokenRequest(name=name))
        return TokenInfo(*_told(answer.token))

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Tokens of the kernel at {self._services.address}>"


def role_name(role: token_pb2.Role) -> str:
    """Return a role of the contract as a word; empty for one that this client does not know."""
    return ROLES[role - 1] if 0 < role <= len(ROLES) else ""


def _told(token: token_pb2.Token) -> tuple[str, str, datetime, str]:
    return token.name, role_name(token.role), token.create_time.ToDatetime(UTC), token.created_by
