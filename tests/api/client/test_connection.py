"""Connecting: what is found by itself, and what is said when it fails."""

from __future__ import annotations

import socket
import threading
from pathlib import Path

import pytest
import trustme
import virtualrobot
from virtualrobot import cli, session

from tests.kernels import KernelProcess, StartKernel


@pytest.fixture(scope="module")
def guarded(start_kernel: StartKernel) -> KernelProcess:
    """Return a kernel that wants a token."""
    return start_kernel(token=True)


def test_address_and_token_come_from_the_environment(guarded: KernelProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIRTUALROBOT_ADDRESS", guarded.address)
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", guarded.token)
    with virtualrobot.connect() as client:
        assert client.info.api_version == "virtualrobot.v1"
        assert client.info.version in repr(client)


@pytest.mark.long
def test_the_token_of_the_same_user_is_found(start_kernel: StartKernel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("VIRTUALROBOT_TOKEN", raising=False)
    kernel = start_kernel(no_token=False)
    with virtualrobot.connect(kernel.address) as client:
        assert client.info.process_id == kernel.process.pid
    file = session.token_path(session.split_address(kernel.address)[1])
    assert file.exists()
    assert kernel.end() == 0
    assert not file.exists()


def test_a_client_finds_the_new_token_of_a_kernel_that_was_started_again(
    start_kernel: StartKernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("VIRTUALROBOT_TOKEN", raising=False)
    kernel = start_kernel(no_token=False)
    file = session.token_path(session.split_address(kernel.address)[1])
    token = file.read_text()
    with virtualrobot.connect(kernel.address) as client, virtualrobot.connect(kernel.address, token.strip()) as given:
        assert kernel.end() == 0
        start_kernel("--port", kernel.address.rpartition(":")[2], no_token=False)
        assert file.read_text() != token
        assert client.scene.nodes()
        assert next(iter(client.scene.watch()))
        with pytest.raises(virtualrobot.AuthenticationError):  # whoever names one means that one
            given.scene.nodes()


def test_a_wrong_or_missing_token_is_told(
    guarded: KernelProcess, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    with pytest.raises(virtualrobot.AuthenticationError, match="the token of the argument is wrong") as refused:
        virtualrobot.connect(guarded.address, "wrong")
    assert (refused.value.reason, refused.value.code) == ("UNAUTHENTICATED", "UNAUTHENTICATED")
    monkeypatch.delenv("VIRTUALROBOT_TOKEN", raising=False)
    # The kernel of these tests keeps its token in a file of its own, not where clients look.
    with pytest.raises(virtualrobot.AuthenticationError, match="there is no token for it in"):
        virtualrobot.connect(guarded.address)


def test_a_token_file_is_read(guarded: KernelProcess, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    token = tmp_path / "token"
    for text, code in ((guarded.token, 0), ("wrong", 1)):
        token.write_text(f"{text}\n")
        with pytest.raises(SystemExit) as ended:
            cli.main(["--address", guarded.address, "ls", "--token-file", str(token)])
        assert ended.value.code == code
    assert f"the token of the file {token} is wrong" in capsys.readouterr().err


@pytest.mark.long
def test_the_kernel_takes_its_token_from_the_environment_as_its_clients_do(
    start_kernel: StartKernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", "chosen-by-hand")
    kernel = start_kernel(token=False, no_token=False)
    with virtualrobot.connect(kernel.address) as client:
        assert client.info.process_id == kernel.process.pid
    with pytest.raises(virtualrobot.AuthenticationError, match="the token of the argument is wrong"):
        virtualrobot.connect(kernel.address, "another")


def test_a_token_and_a_file_of_one_are_told_apart(
    guarded: KernelProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (file := tmp_path / "token").write_text(guarded.token)
    virtualrobot.connect(guarded.address, token_file=file).close()
    with pytest.raises(
        virtualrobot.InvalidArgumentError, match="is the path of a file; --token-file and token_file take files"
    ):
        virtualrobot.connect(guarded.address, str(file))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="a token itself goes into VIRTUALROBOT_TOKEN"):
        virtualrobot.connect(guarded.address, token_file=guarded.token)
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", str(tmp_path / "elsewhere"))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="VIRTUALROBOT_TOKEN is the token itself, and what it"):
        virtualrobot.connect(guarded.address)
    monkeypatch.delenv("VIRTUALROBOT_TOKEN")
    with pytest.raises(SystemExit):
        cli.main(["--address", guarded.address, "ls", "--token-file", guarded.token])
    assert guarded.token not in capsys.readouterr().err
    with pytest.raises(virtualrobot.InvalidArgumentError, match="and not both"):
        virtualrobot.connect(guarded.address, guarded.token, token_file=file)


def test_nobody_listens() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))  # bound and not listening: nobody else can be there
        address = f"127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(virtualrobot.KernelGoneError, match=f"{address}: nothing listens there") as refused:
            virtualrobot.connect(address, "token")
        assert isinstance(refused.value, ConnectionError)
        assert (refused.value.reason, refused.value.code) == ("NOT_RUNNING", "UNAVAILABLE")
        assert "start one with 'virtualrobot serve'" in str(refused.value)


def test_something_else_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        stop = threading.Event()

        def answer() -> None:
            while not stop.is_set():
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                with connection:
                    connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            with pytest.raises(virtualrobot.VirtualRobotError):
                virtualrobot.connect(f"127.0.0.1:{server.getsockname()[1]}", "token", timeout=5)
        finally:
            stop.set()
            server.shutdown(socket.SHUT_RDWR)
            thread.join()


@pytest.mark.long
def test_tls(start_kernel: StartKernel, tmp_path: Path) -> None:
    authority = trustme.CA()
    certificate = authority.issue_cert("localhost", "127.0.0.1")
    root, chain, key = tmp_path / "root.pem", tmp_path / "chain.pem", tmp_path / "key.pem"
    authority.cert_pem.write_to_path(root)
    certificate.cert_chain_pems[0].write_to_path(chain)
    certificate.private_key_pem.write_to_path(key)
    kernel = start_kernel("--tls-certificate", str(chain), "--tls-key", str(key))
    with virtualrobot.connect(kernel.address, root_certificate=root) as client:
        assert client.scene.node("world").kind == "world"
    other = tmp_path / "other.pem"
    trustme.CA().cert_pem.write_to_path(other)
    with pytest.raises(virtualrobot.KernelGoneError, match="signed by nobody that this program trusts"):
        virtualrobot.connect(kernel.address, root_certificate=other)
    other.write_text("no certificate")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"other\.pem is no root certificate"):
        virtualrobot.connect(kernel.address, root_certificate=other)


@pytest.mark.long
def test_a_kernel_that_ends_is_told_at_once(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    client = virtualrobot.connect(kernel.address)
    watch = client.clock.watch()
    assert next(watch).mode == "realtime"
    client.shutdown()
    with pytest.raises(virtualrobot.KernelGoneError) as gone:
        for _ in watch:
            pass
    assert gone.value.reason == "SHUTTING_DOWN"
    assert kernel.process.wait(30) == 0
    with pytest.raises(virtualrobot.KernelGoneError):
        client.clock.read()
    client.close()


def test_a_closed_client_says_so(guarded: KernelProcess) -> None:
    client = virtualrobot.connect(guarded.address, guarded.token)
    client.close()
    with pytest.raises(virtualrobot.ClientClosedError, match="connect again"):
        client.clock.read()
    with pytest.raises(virtualrobot.ClientClosedError):
        next(client.clock.watch())


@pytest.mark.long
def test_a_kernel_of_ones_own_ends_with_its_client(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIRTUALROBOT_ADDRESS", "local")
    with virtualrobot.connect() as client:
        address = client.address
        assert not list(client.robots())
    with pytest.raises(virtualrobot.KernelGoneError):
        virtualrobot.connect(address, timeout=1.0)


def test_a_kernel_of_ones_own_takes_no_token() -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="needs neither token nor certificate"):
        virtualrobot.connect("local", "secret")
