"""How the viewer behaves around its picture: ports, browsers that come and go, errors, framing, and nothing outside."""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import msgspec
import numpy as np
import pytest
import viser._viser
import zstandard
from virtualrobot_kernel.drawing.page_server import PORTS_TRIED
from virtualrobot_kernel.drawing.view import Camera, ViewSettings, ViewStore
from virtualrobot_kernel.drawing.viewer import Viewer
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.xml import FileWarning
from virtualrobot_kernel.world.commands import RemoveNode
from virtualrobot_kernel.world.figures import Box, Figure, Material
from virtualrobot_kernel.world.state import Snapshot
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from tests.drawing.cell import Cell, at
from tests.drawing.conftest import HEIGHT, WIDTH, Stage, on_stage
from tools.screenshot import picture

BACKGROUND = (0.2, 0.4, 0.6)
PURPLE = Figure(Box((0.5, 0.5, 0.5)), material=Material((0.6, 0.0, 0.8, 1.0)))


@pytest.fixture
def stage() -> Iterator[Stage]:
    """Give a viewer without a camera of its own."""
    with on_stage(ViewStore(ViewSettings(background=BACKGROUND, grid_hidden=True))) as stage:
        yield stage


def foreground(stage: Stage) -> tuple[np.ndarray, ...]:
    """Return rows and columns of all pixels that show something before the background."""
    difference = np.abs(stage.pixels().astype(int) - np.rint(255 * np.array(BACKGROUND)))
    return np.nonzero(difference.max(axis=2) > 12)


def seen_at(stage: Stage) -> tuple[float, float, int]:
    """Return the middle of what is before the background, from 0 to 1 to the right and down, and its pixels."""
    rows, columns = foreground(stage)
    if len(rows) == 0:
        return 0.0, 0.0, 0
    return (columns.min() + columns.max()) / 2 / WIDTH, (rows.min() + rows.max()) / 2 / HEIGHT, len(rows)


def extent(stage: Stage) -> tuple[int, int]:
    """Return the columns where what is seen begins and ends."""
    columns = foreground(stage)[1]
    return (int(columns.min()), int(columns.max())) if len(columns) else (0, 0)


def in_the_middle(stage: Stage) -> bool:
    """Return whether something is seen in the middle of the picture and not all over it."""
    right, down, pixels = seen_at(stage)
    return abs(right - 0.5) < 0.06 and abs(down - 0.5) < 0.12 and 500 < pixels < 0.5 * WIDTH * HEIGHT


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        yield taken.getsockname()[1]


def test_when_its_port_is_in_use_the_viewer_takes_one_of_the_next(taken_port: int) -> None:
    cell = Cell()
    viewer = Viewer(lambda: cell.snapshot, ViewStore(), cell.meshes, port=taken_port)
    viewer.start()
    port = int(viewer.url.rpartition(":")[2])
    viewer.close()
    assert taken_port < port < taken_port + PORTS_TRIED


def test_when_no_port_is_free_the_error_names_them(taken_port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("virtualrobot_kernel.drawing.page_server.PORTS_TRIED", 1)
    cell = Cell()
    viewer = Viewer(lambda: cell.snapshot, ViewStore(), cell.meshes, port=taken_port)
    with pytest.raises(KernelError, match=str(taken_port)) as refused:
        viewer.start()
    assert refused.value.metadata == {"host": "127.0.0.1", "port": str(taken_port)}
    viewer.close()
    assert viewer.url == ""


def test_only_its_own_page_may_look() -> None:
    """RFC 6455, section 10.2: a server that is not for any web page checks the Origin."""
    viewer = Viewer(lambda: Cell().snapshot, ViewStore(), Cell().meshes)
    viewer.start()
    port = int(viewer.url.rpartition(":")[2])
    for host, origin, may in (
        (f"127.0.0.1:{port}", f"http://127.0.0.1:{port}", True),
        (f"localhost:{port}", f"http://localhost:{port}", True),
        ("localhost:9000", "http://localhost:9000", True),  # a forwarded port
        (f"[::1]:{port}", f"http://[::1]:{port}", True),
        (f"127.0.0.1:{port}", None, True),  # no browser
        (f"127.0.0.1:{port}", "http://evil.example", False),
        (f"127.0.0.1:{port}", "http://localhost:3000", False),  # another site of this machine
        (f"127.0.0.1:{port}", "null", False),  # a sandboxed frame
        (f"evil.example:{port}", f"http://evil.example:{port}", False),  # a name that was made to point here
        (f"evil.example:{port}", None, False),
        ("127.0.0.1.evil.example", None, False),
        ("[", None, False),
    ):
        for upgrade in (True, False):
            lines = ["GET / HTTP/1.1", f"Host: {host}", *([f"Origin: {origin}"] if origin else [])]
            if upgrade:
                lines += ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13"]
                lines += ["Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="]
            with socket.create_connection(("127.0.0.1", port)) as connection:
                connection.sendall("\r\n".join([*lines, "", ""]).encode())
                status = connection.makefile("rb").readline().split()[1]
            assert status == ((b"101" if upgrade else b"200") if may else b"403"), (host, origin)
    viewer.close()


def test_without_a_browser_nothing_is_drawn_and_closing_ends_the_thread(capsys: pytest.CaptureFixture[str]) -> None:
    def unasked() -> Snapshot:
        raise AssertionError("nobody looks")

    viewer = Viewer(unasked, ViewStore(), Cell().meshes)
    viewer.start()
    assert viewer.url.startswith("http://127.0.0.1:") and viewer.viewer_count == 0
    assert "drawing" in {thread.name for thread in threading.enumerate()}
    viewer.close()
    viewer.close()
    assert "drawing" not in {thread.name for thread in threading.enumerate()}
    assert viewer.url == ""
    assert capsys.readouterr().out == ""  # programs print their own address


@pytest.mark.long
def test_the_scene_is_framed_until_somebody_moves_the_camera(stage: Stage) -> None:
    stage.cell.add("far", PURPLE, pose=at(30.0, -20.0, 5.0))
    stage.wait(lambda: in_the_middle(stage))
    alone = seen_at(stage)[2]
    stage.cell.add("farther", PURPLE, pose=at(34.0, -20.0, 5.0))
    # Now both are seen, smaller, and together in the middle (the nearer one somewhat farther from it).
    stage.wait(lambda: 0 < seen_at(stage)[2] < alone and abs(seen_at(stage)[0] - 0.5) < 0.15)
    both = seen_at(stage)[2]
    stage.page.mouse.move(0.85 * WIDTH, 0.2 * HEIGHT)  # where no panel lies over the scene
    stage.page.mouse.wheel(0, 400)
    stage.wait(lambda: seen_at(stage)[2] < 0.8 * both)  # the person has gone away from it
    stage.page.wait_for_timeout(1500)  # the page glides to its end and tells the server where that is
    left, right = extent(stage)
    stage.cell.add("farthest", PURPLE, pose=at(30.0, -20.0, 95.0))
    stage.cell.do(RemoveNode("far"))
    stage.wait(lambda: extent(stage)[0] > left + 20)  # what has changed is drawn,
    assert extent(stage)[1] == pytest.approx(right, abs=2)  # but from where the person has gone


@pytest.mark.long
def test_browsers_come_and_go(stage: Stage) -> None:
    stage.wait(lambda: stage.viewer.viewer_count == 1)
    browser = stage.page.context.browser
    assert browser is not None
    stage.page.close()
    stage.cell.add("box", PURPLE)
    late = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    late.goto(f"{stage.viewer.url}/?fixedDpr=1")
    late.wait_for_function("window.__viserMutable && window.__viserMutable.canvas !== null")
    stage.page = late
    stage.wait(lambda: in_the_middle(stage))
    assert stage.viewer.viewer_count == 1


@contextmanager
def listening(view: ViewStore) -> Iterator[Callable[[bytes], bytes]]:
    """Give what waits until a page is told some bytes, and returns all that came with them.

    It speaks viser's own protocol, as what says of itself that it is a page: lengths, then messages packed by zstd.
    """
    viewer = Viewer(lambda: Cell().snapshot, view, Cell().meshes)
    viewer.start()
    camera = {"type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, -4.0, 0.0), "fov": 0.9,
              "near": 0.01, "far": 100.0, "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
              "image_height": 90, "image_width": 90}  # fmt: skip
    protocol = Subprotocol(f"viser-v{viser.__version__}")
    with connect(viewer.url.replace("http", "ws"), subprotocols=[protocol], max_size=None) as page:
        page.send(msgspec.msgpack.encode(camera))

        def told(word: bytes) -> bytes:
            while True:  # the test's own deadline ends a wait for ever
                received = page.recv(timeout=60.0)
                assert isinstance(received, bytes)
                came = zstandard.ZstdDecompressor().decompressobj().decompress(received[16:])
                if word in came:
                    return came

        yield told
    viewer.close()


def test_a_warning_about_a_file_is_a_message_on_the_page() -> None:
    view = ViewStore()
    view.tell([FileWarning("model.urdf:3: something is odd")])
    with listening(view) as told:
        assert b"NotificationShowMessage" in told(b"something is odd")
        assert view.take_messages() == []


def test_what_the_kernel_is_busy_with_is_a_note_on_the_page_until_it_is_done() -> None:
    view = ViewStore()
    with listening(view) as told:
        with view.under_way.doing("loading a model"):
            assert b"NotificationShowMessage" in told(b"loading a model")
        told(b"RemoveNotificationMessage")
    assert view.under_way.long() == ()


@pytest.mark.long
def test_an_error_is_told_once_and_drawing_goes_on(stage: Stage, caplog: pytest.LogCaptureFixture) -> None:
    stage.view.update(camera=Camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0)))
    stage.cell.add("box", PURPLE)
    # A front of 0.5 m, 3.75 m away, is 49.7 pixels wide: 360 / 2 / tan(0.9 / 2) * 0.5 / 3.75.
    stage.wait(lambda: seen_at(stage)[2] == pytest.approx(49.7**2, rel=0.1))
    good, before = stage.cell.snapshot, seen_at(stage)[2]
    caplog.set_level(logging.ERROR)
    stage.cell.snapshot = None  # pyright: ignore[reportAttributeAccessIssue]  what must not be, on purpose
    stage.wait(lambda: len(caplog.records) > 0)
    stage.page.wait_for_timeout(1500)  # longer than the pause after an error
    stage.cell.snapshot = good
    stage.cell.add("larger", Figure(Box((0.5, 0.5, 0.9)), material=PURPLE.material))
    stage.wait(lambda: seen_at(stage)[2] > before)
    assert len(caplog.records) == 1


@pytest.mark.long
def test_the_page_asks_nobody_outside_and_gets_no_tunnel(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    tunnels: list[object] = []
    monkeypatch.setattr(viser._viser, "ViserTunnel", lambda *args, **kwargs: tunnels.append(args))
    asked: list[str] = []
    stage.page.on("request", lambda request: asked.append(request.url))
    stage.page.on("websocket", lambda websocket: asked.append(websocket.url))
    stage.page.reload()
    stage.page.wait_for_function("window.__viserMutable && window.__viserMutable.canvas !== null")
    stage.cell.add("box", PURPLE)
    stage.wait(lambda: seen_at(stage)[2] > 500)
    stage.page.evaluate("window.__viserMutable.sendMessage({type: 'ShareUrlRequest'})")
    stage.cell.do(RemoveNode("box"))
    stage.wait(lambda: seen_at(stage)[2] == 0)
    stage.page.wait_for_timeout(300)
    address = stage.viewer.url.removeprefix("http://")
    places = ("http://" + address, "ws://" + address, "blob:http://" + address, "data:")
    assert len(asked) > 1
    assert [url for url in asked if not url.startswith(places)] == []
    assert tunnels == []


def test_a_picture_is_a_png_of_the_asked_size(stage: Stage) -> None:
    data = picture(stage.page)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert stage.pixels().shape == (HEIGHT, WIDTH, 3)


@pytest.mark.long
def test_the_live_view_stands_in_a_notebook(stage: Stage) -> None:
    """The page draws within another page, as `client.view` in a notebook has it."""
    frame = f'<iframe src="{stage.viewer.url}" title="Live view" width="100%" height="480"></iframe>'
    browser = stage.page.context.browser
    assert browser is not None
    page = browser.new_page()
    page.set_content(frame)
    page.frame_locator("iframe").locator("canvas").first.wait_for()
    page.close()
