"""Sockets of RAPID: servers and clients by TCP, what ends them, and that nobody listens without leave."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
import virtualrobot
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded, main_prints
from tests.waiting import until

SERVER = r"""
MODULE Server
  VAR socketdev listening;
  VAR socketdev peer;

  PROC main()
    VAR string line;
    VAR string host;
    VAR num value;
    SocketCreate listening;
    SocketBind listening, "192.168.125.1", @PORT@;
    SocketListen listening;
    WHILE TRUE DO
      serve;
    ENDWHILE
  ENDPROC

  PROC serve()
    VAR string line;
    VAR string host;
    VAR num value;
    TPWrite "waiting";
    SocketAccept listening, peer \ClientAddress:=host \Time:=WAIT_MAX;
    TPWrite "served " + host;
    WHILE SocketGetStatus(peer) = SOCKET_CONNECTED DO
      SocketReceive peer \Str:=line \Time:=WAIT_MAX;
      IF line = "stop" EXIT;
      IF StrToVal(line, value) THEN
        @ACT@
        SocketSend peer \Str:=ValToStr(2 * value) + ";";
      ELSE
        SocketSend peer \Str:="no number;";
      ENDIF
    ENDWHILE
  ERROR
    IF ERRNO = ERR_SOCK_CLOSED THEN
      TPWrite "closed";
      SocketClose peer;
      RETURN;
    ENDIF
  ENDPROC
ENDMODULE
"""


def free_port() -> int:
    """Return a port that nobody listens at."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@contextmanager
def serving(task: RapidTask, port: int) -> Iterator[threading.Thread]:
    """Run a program in a thread; it has ended at the end of the block."""

    def run() -> None:
        with suppress(TaskStopped):
            task.run()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield thread
    finally:
        task.stop()
        thread.join(60)
        assert not thread.is_alive()


def connected(port: int, thread: threading.Thread) -> socket.socket:
    """Return a connection to a program, once it listens."""
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), 60)
        except ConnectionRefusedError:
            assert thread.is_alive()


def asked(peer: socket.socket, text: str) -> str:
    """Return the answer to a text, up to its semicolon."""
    peer.sendall(text.encode())
    got = ""
    while not got.endswith(";"):
        got += peer.recv(100).decode()
    return got


def test_a_server_serves_one_client_after_the_other_until_it_is_told_to_end() -> None:
    port = free_port()
    lines: list[str] = []
    program = loaded(SERVER.replace("@PORT@", str(port)).replace("@ACT@", ""))
    task = RapidTask(program, write=lines.append, listen_at="127.0.0.1")
    with serving(task, port) as thread:
        with connected(port, thread) as peer:
            assert [asked(peer, text) for text in ("21", "-0.5", "words")] == ["42;", "-1;", "no number;"]
        with connected(port, thread) as peer:
            assert asked(peer, "1") == "2;"
            peer.sendall(b"stop")
            thread.join(60)
    assert lines == ["waiting", "served 127.0.0.1", "closed", "waiting", "served 127.0.0.1"]
    with socket.create_server(("127.0.0.1", port)):
        pass  # it listens no more


def test_a_server_moves_the_robot_for_its_client(client: virtualrobot.Client) -> None:
    client.clock.speed_factor = 5.0
    arm = client.load_robot("model://irb120", name="arm")
    port = free_port()
    move = "MoveAbsJ [[value,0,0,0,30,0],[0,0,0,0,0,0]], v1000, fine, tool0;"
    program = loaded(SERVER.replace("@PORT@", str(port)).replace("@ACT@", move))
    task = RapidTask(program, World(client, "arm"), write=lambda _: None, listen_at="127.0.0.1")
    with serving(task, port) as thread, connected(port, thread) as peer:
        for degrees in (30, -20):
            assert asked(peer, str(degrees)) == f"{2 * degrees};"
            assert arm.positions[0] == pytest.approx(degrees * 3.14159265 / 180, abs=1e-6)


def test_nobody_listens_without_leave() -> None:
    port = free_port()
    program = loaded(SERVER.replace("@PORT@", str(port)).replace("@ACT@", ""))
    with pytest.raises(RapidStopped, match=rf"test.mod:10: the program wants to listen at port {port}: .*--listen"):
        RapidTask(program).run()


def test_a_program_that_waits_for_a_client_can_be_stopped() -> None:
    port = free_port()
    said = threading.Event()
    program = loaded(SERVER.replace("@PORT@", str(port)).replace("@ACT@", ""))
    task = RapidTask(program, write=lambda _: said.set(), listen_at="127.0.0.1")
    found: list[BaseException] = []

    def run() -> None:
        try:
            task.run()
        except TaskStopped as stopped:
            found.append(stopped)

    thread = threading.Thread(target=run)
    thread.start()
    assert said.wait(60)
    task.stop("by hand")
    thread.join(60)
    assert [str(one) for one in found] == ["by hand"]


def test_a_client_in_rapid_sends_and_receives_bytes() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def serve() -> None:
            peer, _ = server.accept()
            with peer:
                peer.sendall(bytes(reversed(peer.recv(3))))
                peer.sendall(bytes(reversed(peer.recv(2))))

        thread = threading.Thread(target=serve)
        thread.start()
        assert main_prints(
            rf"""
            VAR socketdev s;
            VAR num data{{5}} := [1, 2, 255, 0, 0];
            VAR num count;
            VAR rawbytes raw;
            SocketCreate s;
            SocketConnect s, "127.0.0.1", {port} \Time:=10;
            TPWrite "" \Num:=SocketPeek(s);
            SocketSend s \Data:=data \NoOfBytes:=3;
            WHILE SocketPeek(s) < 3 DO
            ENDWHILE
            SocketReceive s \Data:=data \ReadNoOfBytes:=3 \NoRecBytes:=count;
            TPWrite ValToStr(data) \Num:=count;
            PackRawBytes 258, raw \Network, 1 \IntX:=UINT;
            SocketSend s \RawData:=raw;
            SocketReceive s \RawData:=raw \ReadNoOfBytes:=2;
            UnpackRawBytes raw, 1, count \IntX:=UINT;
            TPWrite "" \Num:=count + RawBytesLen(raw);
            SocketReceive s \Data:=data \Time:=10;
            ERROR
              TPWrite "closed " \Bool:=ERRNO = ERR_SOCK_CLOSED;
              SocketClose s;
              TPWrite "closed " \Bool:=SocketGetStatus(s) = SOCKET_CLOSED;
              RETURN;
            """,
            once=True,
        ) == ["0", "[255,2,1,0,0]3", "260", "closed TRUE", "closed TRUE"]
        thread.join(60)


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ('SocketSend s \\Str:="x";', "ERR_SOCK_CLOSED: the socket is closed; SocketCreate it first"),
        ("SocketCreate s; SocketReceive s \\Str:=t;", "ERR_SOCK_NOTCON: the socket is not connected"),
        ("SocketCreate s; reg1 := SocketPeek(s);", "ERR_SOCK_NOTCON: the socket is connected with nobody"),
        ("SocketCreate s; SocketCreate s;", "ERR_SOCK_ISCON: the socket is there already; SocketClose it first"),
        ("SocketCreate s; SocketListen s;", "ERR_SOCK_NOTCON: the socket has no port; SocketBind it first"),
        ('SocketCreate s; SocketConnect s, "127.0.0.1", @PORT@;', "ERR_SOCK_CONNREF: 127.0.0.1:"),
    ],
)
def test_what_sockets_can_not_do_is_an_error_with_a_name(statements: str, expected: str) -> None:
    with pytest.raises(RapidStopped) as caught:
        main_prints(statements.replace("@PORT@", str(free_port())), "VAR socketdev s; VAR string t;")
    assert str(caught.value).partition(": ")[2].startswith(expected)


def test_bits_and_bytes() -> None:
    """The values by hand: 38 is 100110, 53 is 110101."""
    assert main_prints(
        r"""
        VAR byte b := 38;
        TPWrite "" \Num:=BitAnd(38, 53); TPWrite "" \Num:=BitOr(38, 53); TPWrite "" \Num:=BitXOr(38, 53);
        TPWrite "" \Num:=BitNeg(38); TPWrite "" \Num:=BitLSh(38, 3); TPWrite "" \Num:=BitRSh(38, 2);
        BitSet b, 1; BitClear b, 6;
        TPWrite "" \Num:=b \Bool:=TRUE;
        """.replace(r" \Bool:=TRUE", "")
        + r"""
        TPWrite ByteToStr(122) + ByteToStr(122 \Hex) + ByteToStr(122 \Okt) + ByteToStr(122 \Bin) + ByteToStr(122 \Char);
        TPWrite "" \Num:=StrToByte("7A" \Hex) + StrToByte("172" \Okt) + StrToByte("z" \Char) + StrToByte("122");
        TPWrite "" \Bool:=BitCheck(38, 3);
        """
    ) == ["36", "55", "19", "217", "48", "9", "7", "1227A17201111010z", "488", "TRUE"]


def test_datagrams_go_and_come_with_the_address_of_their_sender() -> None:
    port = free_port()
    text = r"""
    MODULE Datagrams
      PROC main()
        VAR socketdev here;
        VAR rawbytes raw;
        VAR string line;
        VAR string host;
        VAR num sender;
        VAR num data{3};
        VAR num count;
        SocketCreate here \UDP;
        SocketBind here, "192.168.125.1", @PORT@;
        TPWrite "bound";
        SocketReceiveFrom here \Str:=line \NoRecBytes:=count, host, sender \Time:=60;
        TPWrite line + " from " + host \Num:=count;
        SocketSendTo here, host, sender \Str:=line + "!";
        PackRawBytes 258, raw, 1 \IntX:=INT;
        SocketSendTo here, host, sender \RawData:=raw;
        SocketReceiveFrom here \Data:=data, host, sender;
        TPWrite ValToStr(data);
        SocketReceiveFrom here \Str:=line, host, sender \Time:=0.01;
      ERROR
        IF ERRNO = ERR_SOCK_TIMEOUT TPWrite "nothing";
        TRYNEXT;
      ENDPROC
    ENDMODULE
    """
    lines: list[str] = []
    task = RapidTask(loaded(text.replace("@PORT@", str(port))), write=lines.append, listen_at="127.0.0.1")
    thread = threading.Thread(target=task.run, daemon=True)
    thread.start()
    try:
        with socket.socket(type=socket.SOCK_DGRAM) as peer:
            peer.settimeout(60)
            peer.bind(("127.0.0.1", 0))
            until(lambda: lines == ["bound"])
            peer.sendto(b"hello", ("127.0.0.1", port))
            assert peer.recv(100) == b"hello!"
            assert peer.recv(100) == b"\x02\x01"
            peer.sendto(bytes([1, 2, 3]), ("127.0.0.1", port))
            thread.join(60)
    finally:
        task.stop()
        thread.join(60)
    assert lines == ["bound", "hello from 127.0.0.15", "[1,2,3]", "nothing"]


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        (r'SocketCreate s \UDP; SocketConnect s, "127.0.0.1", 9;', "the socket is for datagrams"),
        (
            r'SocketCreate s; SocketSendTo s, "127.0.0.1", 9 \Str:="";',
            r"the socket is for TCP; SocketCreate it with \\UDP",
        ),
        (r'SocketCreate s \UDP; SocketSendTo s, "127.0.0.1", 99999 \Str:="";', "127.0.0.1:99999: "),
        (r"SocketCreate s \UDP; SocketReceiveFrom s \Str:=t, t, n;", "the socket has no port; SocketBind it first"),
        (r"SocketCreate s \UDP; SocketReceiveFrom s, t, n;", r"SocketReceiveFrom needs \\Str, \\RawData or \\Data"),
    ],
)
def test_sockets_of_one_kind_are_not_used_as_the_other(statements: str, expected: str) -> None:
    with pytest.raises(RapidStopped, match=expected):
        main_prints(statements, "VAR socketdev s; VAR string t; VAR num n;")
