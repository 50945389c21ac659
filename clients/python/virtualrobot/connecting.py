"""The way to a kernel: its address, its token, its version, and the client that speaks with it."""

from __future__ import annotations

from pathlib import Path

from virtualrobot._wire.arguments import Text, checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.transport import open_channel
from virtualrobot.connection import Client, KernelInfo
from virtualrobot.errors import AuthenticationError, InvalidArgumentError, VersionError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.leases import program_name
from virtualrobot.progress import OnProgress, show_progress
from virtualrobot.session import checked_token, default_address, find_token, split_address, token_path
from virtualrobot.v1 import kernel_pb2

API_VERSION = "virtualrobot.v1"
LOCAL = "local"
"""Address of a kernel that this program starts for itself."""

LONGEST_NAME = 200
"""Most characters of what a client calls itself."""


@checked
def connect(
    address: str | None = None,
    token: Text | None = None,
    *,
    token_file: str | Path | None = None,
    root_certificate: str | Path | None = None,
    timeout: float = 30.0,
    name: str | None = None,
    on_progress: OnProgress | None = show_progress,
) -> Client:
    """Connect to a kernel and return the client.

    Args:
        address: `host:port`; `local` starts a kernel, with its viewer, that ends with this client or this program.
            Default: the environment variable VIRTUALROBOT_ADDRESS, or 127.0.0.1:50500.
        token: the token itself. Where neither it nor `token_file` is given, the environment variable
            VIRTUALROBOT_TOKEN is the token, or else the file that a kernel of this user on this machine wrote has it.
        token_file: the file that holds the token.
        root_certificate: a PEM file; beyond this machine TLS is always used, by default with the system's certificates.
        timeout: deadline of a call (s); that of calls that move files is ten minutes.
        name: what this client calls itself in the history, up to 200 characters; by default user, machine and program.
            Clients of the same name on one machine count as one where only their own changes are asked for.
        on_progress: is called with a `Progress` while planning, loading or a search for a path takes more than half a
            second; by default a line of stderr shows it where that is a terminal. What it raises ends the call, as
            Ctrl-C does. None: nothing is told.

    Raises:
        KernelGoneError: when no kernel answers there.
        InvalidArgumentError: when the address or the token is none.
        AuthenticationError: when the token is missing or wrong.
        VersionError: when the kernel speaks another version of the contract.

    Example:
        >>> with virtualrobot.connect() as client:
        ...     robot = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
        ...     robot.move_joints([0, 0.5, 0, -1.2, 0, 0.8, 0])
    """
    address = address or default_address()
    if address == LOCAL:
        if token or token_file or root_certificate:
            raise InvalidArgumentError("a kernel of one's own needs neither token nor certificate; leave them out")
        own_kernel = KernelProcess()
        try:
            client = connect(own_kernel.address, timeout=timeout, name=name, on_progress=on_progress)
        except BaseException:
            own_kernel.close()
            raise
        client._own_kernel = own_kernel
        return client
    if token and token_file:
        raise InvalidArgumentError("give token, the token itself, or token_file, the file that holds it, and not both")
    try:
        host, port = split_address(address)
        file = None if token_file is None else Path(token_file)
        given = checked_token(token, "token") if token else ""
        token, origin = (given, "the argument") if given else find_token(port, file)
    except ValueError as error:
        raise InvalidArgumentError(str(error)) from error
    target = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    certificate = None if root_certificate is None else Path(root_certificate)
    name = program_name() if name is None else name
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise InvalidArgumentError(f"name has at most {LONGEST_NAME} characters that can be printed, not {name!r:.80}")
    channel = open_channel(target, host, token, certificate, timeout, name)
    channel.on_progress = on_progress
    try:
        info = Services(channel, target).kernel.GetInfo(kernel_pb2.GetInfoRequest(), timeout=min(timeout, 10.0))
        if info.api_version != API_VERSION:
            raise VersionError(
                f"the kernel at {target} (VirtualRobot {info.version}) speaks {info.api_version or 'nothing known'}, "
                f"this client {API_VERSION}: install the same version of both"
            )
    except AuthenticationError as error:
        channel.close()
        said = f"the token of {origin} is wrong" if token else f"there is no token for it in {token_path(port)}"
        raise AuthenticationError(
            f"the kernel at {target} refuses this client: {said}; VIRTUALROBOT_TOKEN is its token itself, --token-file "
            "names a file that holds it, and goes first",
            error.reason,
            error.metadata,
            error.code,
        ) from error
    except BaseException:
        channel.close()
        raise
    if not given:
        channel.find_token = lambda: find_token(port, file)[0]
    return Client(channel, target, KernelInfo.of(info))
