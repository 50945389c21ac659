"""Command `virtualrobot serve`: starts a kernel, prints its address, ends it on SIGTERM, Ctrl-C or Shutdown."""

from __future__ import annotations

import argparse
import contextlib
import functools
import gc
import logging
import os
import secrets
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from virtualrobot.session import DEFAULT_HOST, DEFAULT_PORT, given_token, is_loopback, token_path

from virtualrobot_kernel.api.limits import Limits, described
from virtualrobot_kernel.background import share_memory
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.recent_log import FolderLog, RecentLog, kept_log

if TYPE_CHECKING:
    from virtualrobot.console_process import ConsoleProcess

    from virtualrobot_kernel.components.catalog import Catalog
    from virtualrobot_kernel.history.past import PastFolder
    from virtualrobot_kernel.world.clock import Clock

log = logging.getLogger(__name__)

RECENT = RecentLog()
"""Newest lines of the log, for reports."""

CLOSE_SECONDS = 20.0
"""Longest time (s) that the rooms may take to close before the process ends without them."""

LAST_THREADS_SECONDS = 5.0
"""Longest time (s) after that for threads which may never return: those of components in this process."""

SWITCH_INTERVAL_SECONDS = 0.0005
"""Greatest time (s) that a thread may hold the interpreter while others wait: measured for calls' shortest tail."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a kernel until it is told to end; return the exit code."""
    return _told("virtualrobot serve", _parser().parse_args(arguments), _serve)


def replay(arguments: Sequence[str] | None = None) -> int:
    """Run a kernel that replays a folder until it is told to end, or only verify it; return the exit code."""
    options = _replay_parser().parse_args(arguments)
    return _told("virtualrobot replay", options, _verify if options.verify else _serve_past)


def report(path: Path, target: Path) -> None:
    """Write the report of a project folder; raise KernelError when it is none, or damaged."""
    from virtualrobot_kernel.report import report_of_folder

    report_of_folder(path, target)


def repair(path: Path) -> str:
    """Repair a project folder and return what came of it; raise KernelError when it can't be."""
    from virtualrobot_kernel.history.repair import repair as repaired
    from virtualrobot_kernel.planning.robots import world_poses

    done = repaired(path, world_poses)
    return f"{path} is sound" if done is None else str(done)


def _told(name: str, options: argparse.Namespace, run: Callable[[argparse.Namespace], int]) -> int:
    """Return the exit code of a program; what it refuses is one line."""
    logging.basicConfig(
        level=logging.DEBUG if options.debug else logging.WARNING, format="%(levelname)s %(name)s: %(message)s"
    )
    logging.getLogger().addHandler(RECENT)
    if not options.debug:
        # Read when grpc is imported, below: what fails is said here, once, and not in the words of its C core too.
        os.environ.setdefault("GRPC_VERBOSITY", "NONE")
    try:
        return run(options)
    except KernelError as error:
        if options.debug:
            raise
        print(f"{name}: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("virtualrobot serve", description="Start a kernel and keep it running.")
    parser.add_argument("scene", nargs="?", type=Path, help="a scene file to load first")
    _add_server_options(parser)
    parser.add_argument("--stepped", action="store_true", help="time goes on only when a client steps it")
    parser.add_argument(
        "--tick-milliseconds", type=float, help="the length of a tick, from 1 (default: that of --data, else 4)"
    )
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="a folder that keeps world and history: the kernel goes on from it when it is started again",
    )
    parser.add_argument(
        "--durability",
        choices=("process", "power"),
        default="process",
        help="what an answered change survives: the end of the process (default), or a loss of power",
    )
    parser.add_argument(
        "--keep-history",
        metavar="HOW_MUCH",
        help="how much of the history is kept: 500MB, 4GB, 12h, 30d, or both as in 4GB,30d "
        "(default: 4GB with --data, else 64MB)",
    )
    return parser


def _replay_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "virtualrobot replay",
        description="Start a kernel that shows what a project folder has recorded, paused at its first moment.",
    )
    parser.add_argument("data", type=Path, metavar="DIR", help="the folder of `virtualrobot serve --data DIR`")
    parser.add_argument(
        "--verify", action="store_true", help="only make every tick again and compare it with what it was"
    )
    _add_server_options(parser)
    parser.set_defaults(scene=None, stepped=True, tick_milliseconds=None, durability="process", keep_history=None)
    return parser


def _add_server_options(parser: argparse.ArgumentParser) -> None:
    """Add what is said of any kernel: who may call it, and whether it has a viewer."""
    parser.add_argument("--host", default=DEFAULT_HOST, help="the address to listen on (default: this machine only)")
    parser.add_argument("--port", type=int, default=DEFAULT_PORT, help=f"0 for any free one (default: {DEFAULT_PORT})")
    token = "a file, read or, when it isn't there, written; without it VIRTUALROBOT_TOKEN is the token, or one is made"
    parser.add_argument("--token-file", type=Path, help=token)
    parser.add_argument("--no-token", action="store_true", help="let every program of this machine in")
    parser.add_argument("--tls-certificate", type=Path, help="a PEM file; needed beyond this machine")
    parser.add_argument("--tls-key", type=Path, help="the certificate's key, a PEM file")
    parser.add_argument("--headless", action="store_true", help="no viewer and no console")
    parser.add_argument("--no-console", action="store_true", help="a viewer, but no console")
    parser.add_argument(
        "--viewer-port", type=int, default=8080, help="the first port that the viewer tries (default: 8080)"
    )
    files = "a folder that files named in calls may lie in; repeated for several (default: the working folder)"
    parser.add_argument("--files", type=Path, action="append", metavar="FOLDER", help=files)
    names = ", ".join(f"{name} ({default:,})" for name, default, _ in described())
    parser.add_argument(
        "--limit", action="append", default=[], metavar="NAME=VALUE", help=f"sets a limit; there are {names}"
    )
    parser.add_argument(
        "--end-with-input", action="store_true", help="end when the standard input does: for child processes"
    )
    parser.add_argument("--strict-plugins", action="store_true", help="do not start when a plugin has failed")
    parser.add_argument("--debug", action="store_true", help="log more, and show tracebacks")


def _verify(options: argparse.Namespace) -> int:
    """Make every tick of a folder's past again; return 0 when each is what it was."""
    from virtualrobot_kernel.compiling import compile_code
    from virtualrobot_kernel.history.past import PastFolder
    from virtualrobot_kernel.history.verify import verify
    from virtualrobot_kernel.planning.robots import world_poses

    compile_code()
    past = PastFolder(options.data)
    try:
        verdict = verify(past.replay(world_poses), past.store.hashes())
    finally:
        past.close()
    for warning in verdict.warnings:
        print(warning, file=sys.stderr)
    print(verdict)
    return 0 if verdict.tick is None and not verdict.warnings else 1


def _serve_past(options: argparse.Namespace) -> int:
    from virtualrobot_kernel.history.past import PastFolder

    past = PastFolder(options.data)
    options.data = None  # it is read, and not gone on with
    return _serve(options, past)


def _serve(options: argparse.Namespace, past: PastFolder | None = None) -> int:
    _check(options)
    share_memory()
    # What modules make as they are loaded stays: to look for garbage among it takes a fifth of the start's time.
    gc.disable()
    catalog = _catalog(options)
    from virtualrobot_kernel.compiling import compile_code
    from virtualrobot_kernel.history.folder import LOG, NANOSECONDS, TOKENS, Folder
    from virtualrobot_kernel.history.history import rules_of

    # What can be refused is so at once, and not after code was compiled; the folder comes last, which may be made.
    ticks = None if options.tick_milliseconds is None else round(options.tick_milliseconds * 1e6)
    rules = rules_of(options.keep_history, bool(options.data))
    limits, folders = Limits.of(options.limit), _folders(options)
    token = "" if options.no_token else _given_token(options) or secrets.token_urlsafe(32)
    tls = [_read(path) for path in (options.tls_certificate, options.tls_key) if path]
    folder = Folder(options.data, ticks) if options.data else None
    compile_code()
    catalog.remember()
    from virtualrobot_kernel.api.server import Address
    from virtualrobot_kernel.kernel import Kernel, Settings
    from virtualrobot_kernel.world.clock import Mode

    sys.setswitchinterval(SWITCH_INTERVAL_SECONDS)
    ended = threading.Event()
    project = folder.project if folder else past and past.project
    settings = Settings(
        Address(options.host, options.port, token, *tls),
        Mode.STEPPED if options.stepped else Mode.REALTIME,
        project.tick_nanoseconds if project else ticks or NANOSECONDS,
        options.viewer_port,
        folder and folder.path / TOKENS,
        folder,
        rules,
        options.durability == "power",
        limits=limits,
        folders=folders,
        past=past,
        log=functools.partial(kept_log, folder.path / LOG) if folder else RECENT.__str__,
    )
    if folder:
        logging.getLogger().addHandler(FolderLog(folder.path / LOG, token, str(RECENT)))
    kernel = Kernel(settings, catalog, ended.set)
    faults: list[threading.ExceptHookArgs] = []

    def fault(about: threading.ExceptHookArgs) -> None:
        # A world without its thread must not pretend to run.
        log.critical("the thread %s failed", about.thread and about.thread.name, exc_info=about.exc_value)
        faults.append(about)
        ended.set()

    threading.excepthook = fault
    for name in ("SIGINT", "SIGTERM", "SIGBREAK"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda *_: ended.set())
    console = None
    try:
        port = kernel.start()
        with _token_file(options, token, port):
            if options.scene:
                kernel.load(options.scene)
            gc.freeze()  # nor is it looked at later, between ticks and as the process ends
            gc.enable()
            print(f"listening on {options.host}:{port}", flush=True)
            threading.Thread(target=_load_the_rest, args=(catalog, ended), name="loading").start()
            if past is not None:
                print(_told_of_past(past, kernel.world.clock), flush=True)
            if not options.headless:
                print(f"viewer at {kernel.start_viewer()}", flush=True)
                console = _console(options, f"{options.host}:{port}", token)
            if options.end_with_input:
                threading.Thread(target=_wait_for_input, args=(ended,), name="input", daemon=True).start()
            while not ended.wait(0.5):  # a wait without timeout can't be interrupted on Windows
                pass
    finally:
        _end_after(CLOSE_SECONDS, 1)
        if console is not None:
            console.close()
        kernel.close()
        _end_after(LAST_THREADS_SECONDS, 1 if faults else 0)
    return 1 if faults else 0


def _console(options: argparse.Namespace, address: str, token: str) -> ConsoleProcess | None:
    """Start the console beside the kernel, where it is installed and can be asked for a link by this terminal alone."""
    from virtualrobot.console_process import ConsoleProcess, console_is_installed

    if options.no_console or options.tls_certificate or not console_is_installed():
        return None
    return ConsoleProcess(address, token, functools.partial(print, flush=True))


def _told_of_past(past: PastFolder, clock: Clock) -> str:
    """Return in words what a replay has."""
    assert clock.recorded is not None  # it is that of a replay
    first, last = (tick * clock.tick_seconds for tick in (clock.recorded.first_tick, clock.recorded.last_tick))
    return f"replay of {past.path}: {first:.3f} s to {last:.3f} s; paused at its begin"


def _end_after(seconds: float, code: int) -> None:
    """End the process with an exit code after some seconds, if it has not ended by itself before."""

    def end() -> None:
        own = (threading.main_thread(), threading.current_thread())
        running = ", ".join(one.name for one in threading.enumerate() if one not in own)
        log.warning("ended by force after %g s, while these threads ran: %s", seconds, running)
        logging.shutdown()
        os._exit(code)

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()


def _wait_for_input(ended: threading.Event) -> None:
    """Read until standard input ends, as it does however its other end died."""
    while os.read(sys.stdin.fileno(), 4096):
        pass
    ended.set()


def _check(options: argparse.Namespace) -> None:
    """Refuse to listen beyond this machine without TLS and a token."""
    if bool(options.tls_certificate) != bool(options.tls_key):
        raise KernelError("--tls-certificate and --tls-key go together")
    if options.tick_milliseconds is not None and not 1.0 <= options.tick_milliseconds <= 100.0:
        raise KernelError(f"a tick may last 1 to 100 milliseconds, not {options.tick_milliseconds:g}")
    if not 0 <= options.port <= 65535:
        raise KernelError(f"a port is 0 to 65535, not {options.port}")
    if is_loopback(options.host):
        return
    if not options.tls_certificate:
        raise KernelError(f"{options.host} is reachable from other machines: give --tls-certificate and --tls-key")
    if options.no_token:
        raise KernelError(f"{options.host} is reachable from other machines: --no-token is for this machine only")


def _folders(options: argparse.Namespace) -> tuple[Path, ...]:
    """Return where files may lie that calls name: the given folders, or the working folder, and that of the scene.

    A working folder above the user's own, such as the disk's root, counts for nothing.
    """
    if missing := [folder for folder in options.files or () if not folder.is_dir()]:
        raise KernelError(f"--files names no folder: {missing[0]}", reason=Reason.MISSING_FILE, file=missing[0])
    here, home = Path.cwd(), Path.home()
    default = [here] if here == home or not home.is_relative_to(here) else []
    scene = [options.scene.absolute().parent] if options.scene else []
    return tuple(dict.fromkeys(folder.absolute() for folder in (*(options.files or default), *scene)))


def _catalog(options: argparse.Namespace) -> Catalog:
    """Find the plugins; with --strict-plugins refuse to start when one has failed."""
    from virtualrobot_kernel.components.catalog import Catalog

    catalog = Catalog()
    failed = [f"{plugin.name!r} of {plugin.package}: {plugin.reason}" for plugin in catalog.plugins if plugin.reason]
    if options.strict_plugins and failed:
        raise KernelError(f"plugins have failed: {'; '.join(failed)}")
    return catalog


def _load_the_rest(catalog: Catalog, ended: threading.Event) -> None:
    """Load what the first call need not wait for, before somebody has to: compiled code and plugins.

    The process ends between two functions, never in one: LLVM is not to be taken away from a thread that is in it.
    """
    from virtualrobot_sdk.compiled.cache import make_ready

    make_ready(ended.is_set)
    if not ended.is_set():
        catalog.load()
        make_ready(ended.is_set)


def _given_token(options: argparse.Namespace) -> str:
    """Return the token of the token file, where it is there, or of the environment; "" for one that is made."""
    if options.token_file and not options.token_file.exists():
        return ""
    try:
        return given_token(options.token_file)[0]
    except ValueError as error:
        raise KernelError(str(error)) from error


@contextlib.contextmanager
def _token_file(options: argparse.Namespace, token: str, port: int) -> Iterator[None]:
    """Keep the token where clients of this user look for it, readable by nobody else, while the kernel runs."""
    if not token or (options.token_file and options.token_file.exists()):
        yield
        return
    path = options.token_file or token_path(port)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
        file.write(token)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            if path.read_text("utf-8") == token:
                path.unlink()


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise KernelError(f"cannot read {path}: {error.strerror}") from error


if __name__ == "__main__":
    sys.exit(main())
