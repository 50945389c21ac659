"""TokenService: tokens are made, told and withdrawn."""

from __future__ import annotations

from google.protobuf.timestamp_pb2 import Timestamp
from virtualrobot.v1 import token_pb2, token_pb2_grpc

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.token_table import Account, Role
from virtualrobot_kernel.messages.codecs import EnumTable

ROLES = EnumTable(Role, token_pb2.Role)


class TokenServicer(token_pb2_grpc.TokenServiceServicer):
    """Servicer of TokenService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._tokens = kernel.tokens

    async def CreateToken(
        self, request: token_pb2.CreateTokenRequest, context: object
    ) -> token_pb2.CreateTokenResponse:
        """Make a token."""
        account, secret = self._tokens.create(request.name, ROLES.read(request.role, "role"), person(context))
        return token_pb2.CreateTokenResponse(token=_message(account), secret=secret)

    async def ListTokens(self, request: token_pb2.ListTokensRequest, context: object) -> token_pb2.ListTokensResponse:
        """Tell which tokens there are."""
        return token_pb2.ListTokensResponse(tokens=map(_message, self._tokens.accounts))

    async def RevokeToken(
        self, request: token_pb2.RevokeTokenRequest, context: object
    ) -> token_pb2.RevokeTokenResponse:
        """Withdraw a token; who listens to the table ends its calls and leases."""
        return token_pb2.RevokeTokenResponse(token=_message(self._tokens.revoke(request.name)))


def _message(account: Account) -> token_pb2.Token:
    created = Timestamp()
    created.FromNanoseconds(round(account.created * 1e9))
    return token_pb2.Token(
        name=account.name, role=ROLES.write(account.role), create_time=created, created_by=account.created_by
    )
