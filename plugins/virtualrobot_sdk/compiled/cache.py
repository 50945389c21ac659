"""Cache of compiled code: its folder, and its compiling or loading before the kernel's threads start.

numba can compile a function in seconds or load it from a file in milliseconds. The files go to a directory of the
user, so that an installation that nobody may write to works too. Each version of a package's sources has its own:
numba compares only the file of the outermost function and would run stale code after an edit of a function that it
calls. So a compiled function may call inlined ones of its own package and of this one, and no others.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import importlib
import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from platformdirs import user_cache_dir

if TYPE_CHECKING:
    from numba.core.types import Type

Function = TypeVar("Function", bound=Callable[..., Any])

_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
"""No GIL; division by zero gives inf, as in NumPy; a * b + c may be rounded once, nothing else is reordered."""
_COMPILED: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True}
_INLINED: dict[str, Any] = {**_OPTIONS, "no_cfunc_wrapper": True}
"""Nobody calls them as C does; tests call inlined ones as Python does."""
_PACKAGE = Path(__file__).parent
_compiled_functions: list[CompiledFunction | CompiledCallback] = []
_setting = threading.RLock()
"""Held by whoever says where numba keeps things."""
_compiling = threading.RLock()
"""Held by whoever compiles or loads: threads may ask for the same function at once. Taken before `_setting`, and not by
modules that are imported: loading imports the module of a function, and waits where another thread just does that."""


@functools.cache
def cache_directory(package: Path) -> Path:
    """Return the directory for compiled code of the package whose sources are in the folder `package`.

    Its parent is what NUMBA_CACHE_DIR says, else `numba` in the user's cache directory. Where that can't be written,
    a temporary directory that ends with the process takes its place (each start compiles).
    """
    # Two installations of the same sources don't share files: numba keeps them by the path of the source.
    sources = hashlib.sha256(f"{sys.implementation.cache_tag} {package}".encode())
    for source in sorted({*_PACKAGE.glob("*.py"), *package.glob("*.py")}):
        sources.update(source.read_bytes())
    name = f"virtualrobot-{version('numba')}-{sources.hexdigest()[:12]}"
    directory = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(user_cache_dir("virtualrobot")) / "numba") / name
    try:
        directory.mkdir(parents=True, exist_ok=True)
        writable = os.access(directory, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        directory = Path(tempfile.mkdtemp(prefix="virtualrobot-numba-"))
        atexit.register(shutil.rmtree, directory, ignore_errors=True)
    return directory


class CompiledFunction:
    """A function compiled by numba for one declared signature, without the GIL; a native handle.

    One signature means that nothing is ever compiled in the middle of a tick because an array came read-only: inputs
    are declared read-only, which takes both kinds. A wrong dtype, rank or layout raises TypeError.
    """

    def __init__(self, function: Callable[..., Any], signature: tuple[Type, ...], options: dict[str, Any]) -> None:
        """Keep `function`, the numba types of its arguments and numba's options; `compile` makes the native code."""
        self.function = function
        self.directory = cache_directory(Path(function.__code__.co_filename).parent)
        self.name = function.__name__.lstrip("_")
        self.__name__ = function.__name__
        self.__doc__ = function.__doc__
        self._signature, self._options = signature, options
        self._ready = False
        _compiled_functions.append(self)

    def __call__(self, *arguments: Any) -> Any:  # noqa: ANN401  what goes in and comes out is the function's own matter
        """Call the native code; the first call compiles or loads it."""
        self.compile()
        return self.dispatcher(*arguments)

    @functools.cached_property
    def dispatcher(self) -> Any:  # noqa: ANN401  numba's own type
        """Return numba's dispatcher, made when it is first asked for: a start makes some sixty functions."""
        from numba import njit

        with _kept_in(self.directory):
            return njit(**_COMPILED, **self._options)(self.function)

    def is_cached(self) -> bool:
        """Tell whether the cache directory has code of this function for this processor."""
        return _is_kept(self.directory, self.function)

    def compile(self) -> bool:
        """Compile or load; return True when it had to be compiled anew."""
        with _compiling:
            if not self._ready:
                _load_numba()
                self.dispatcher.compile(self._signature)
                self.dispatcher.disable_compile()
                self._ready = True
                # Calls go straight to numba's dispatcher from now on, which saves 0.1 µs each. Python looks for what a
                # call does in the type of the object, so this one gets a type of its own.
                direct: Any = type(self.name, (CompiledFunction,), {"__call__": staticmethod(self.dispatcher)})
                self.__class__ = direct
        return bool(self.dispatcher.stats.cache_misses)


class CompiledCallback:
    """A function compiled by numba that a C library calls by its address, from any thread and without the GIL.

    It takes and returns what its signature says, and must not raise. A native handle.
    """

    def __init__(self, function: Callable[..., Any], signature: Any) -> None:  # noqa: ANN401  numba's own type
        """Keep `function` and its numba signature; `compile` makes the native code."""
        self.function, self._signature = function, signature
        self.directory = cache_directory(Path(function.__code__.co_filename).parent)
        self.name = function.__name__.lstrip("_")
        self._native: Any = None
        _compiled_functions.append(self)

    @property
    def address(self) -> int:
        """Return where the native code is, for as long as the process runs; compiled or loaded at the first call."""
        self.compile()
        return self._native.address

    def is_cached(self) -> bool:
        """Tell whether the cache directory has code of this function for this processor."""
        return _is_kept(self.directory, self.function)

    def compile(self) -> bool:
        """Compile or load; return True when it had to be compiled anew."""
        with _compiling:
            if self._native is None:
                _load_numba()
                from numba.core.ccallback import CFunc  # what `numba.cfunc` makes and compiles in one step
                from numba.core.sigutils import normalize_signature

                options = {name: value for name, value in _OPTIONS.items() if name != "nogil"}
                native = CFunc(self.function, normalize_signature(self._signature), locals={}, options=options)
                with _kept_in(self.directory):
                    native.enable_caching()
                native.compile()
                self._native = native
        return not self._native.cache_hits


def callback(signature: Any) -> Callable[[Callable[..., Any]], CompiledCallback]:  # noqa: ANN401
    """Return a decorator that makes a function a `CompiledCallback` of this numba signature."""
    return lambda function: CompiledCallback(function, signature)


def compiled(*signature: Type, exact: bool = False) -> Callable[[Callable[..., Any]], CompiledFunction]:
    """Return a decorator that makes a function a `CompiledFunction` of arguments of these numba types.

    exact: whether a * b + c is rounded twice, so that results are NumPy's to the last bit.
    """
    options = {**_OPTIONS, "fastmath": False} if exact else _OPTIONS
    return lambda function: CompiledFunction(function, signature, options)


def inlined(function: Function) -> Function:
    """Make a function a part of the compiled functions that call it; it has no cache entry of its own.

    numba would compile it once for each number that is written where it is called, and then for all others.
    """
    from numba import njit
    from numba.core.types import unliteral

    dispatcher: Any = njit(**_INLINED)(function)
    fold = dispatcher._compiler.fold_argument_types

    def folded(arguments: Any, named: Any) -> tuple[Any, tuple[Any, ...]]:  # noqa: ANN401  numba's own types
        signature, types = fold(arguments, named)
        return signature, tuple(map(unliteral, types))

    dispatcher._compiler.fold_argument_types = folded
    # To the type checker it stays what it was; numba replaces it by something called the same way.
    return cast("Function", dispatcher)


def array_of(dtype: Type, dimensions: int) -> Type:
    """Return the type of an input: a C-contiguous array, writable or not."""
    from numba.core.types import Array

    return Array(dtype, dimensions, "C", readonly=True)


def output_of(dtype: Type, dimensions: int) -> Type:
    """Return the type of an output: a C-contiguous array that can be written."""
    from numba.core.types import Array

    return Array(dtype, dimensions, "C")


@contextmanager
def _kept_in(directory: Path) -> Iterator[None]:
    """Have numba keep in `directory` what is made cacheable meanwhile."""
    from numba import config

    settings: Any = config  # numba fills in its attributes when it is loaded
    with _setting:
        others, settings.CACHE_DIR = settings.CACHE_DIR, str(directory)
        try:
            yield
        finally:
            settings.CACHE_DIR = others


@functools.cache
def _load_numba() -> None:
    """Load what numba compiles with, but not scipy, a tenth of a kernel's start: numba only asks whether it is there.

    Whoever calls a function of linear algebra has it loaded then.
    """
    from numba.np import linalg

    def look_for_scipy() -> None:
        if find_spec("scipy") is None:
            raise ImportError("scipy is not installed")

    asked, linalg.ensure_blas = linalg.ensure_blas, look_for_scipy
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = asked


def processor() -> str:
    """Return the name of the processor that code is compiled for: this one, or what NUMBA_CPU_NAME says."""
    from llvmlite.binding import get_host_cpu_name
    from numba import config

    settings: Any = config
    return settings.CPU_NAME or get_host_cpu_name()


def files_of_code(*packages: str) -> list[Path]:
    """Return the cache's files of the compiled functions imported so far of these top-level packages."""
    return [
        file
        for one in tuple(_compiled_functions)
        if one.function.__module__.partition(".")[0] in packages
        for file in _kept(one.directory, one.function)
    ]


def _kept(directory: Path, function: Callable[..., Any]) -> list[Path]:
    """Return the files of the cache that know of a function's code, in a directory of these very sources."""
    module = function.__module__.rpartition(".")[2]
    return [*directory.glob(f"*/{module}.{function.__name__}-*.nbi")]


def _is_kept(directory: Path, function: Callable[..., Any]) -> bool:
    """Return whether the cache has a function's code for this processor, whose name and features its files tell."""
    return any(all(mark in code for mark in _marks()) for code in map(Path.read_bytes, _kept(directory, function)))


@functools.cache
def _marks() -> tuple[bytes, bytes]:
    """Return name and features of the processor that code is compiled for, as numba writes them where it keeps code."""
    from numba import config
    from numba.core.codegen import get_host_cpu_features

    settings: Any = config
    chosen = settings.CPU_FEATURES
    return processor().encode(), (get_host_cpu_features() if chosen is None else chosen).encode()


def make_ready(given_up: Callable[[], bool] = bool) -> None:
    """Compile or load every compiled function imported so far; where that was done before it costs next to nothing.

    A component calls this when it is made: its calls have a deadline, and the first would else wait for the compiler.
    `given_up` is asked before each function; where it says True, the rest is left.
    """
    for function in _compiled_functions:
        if given_up():
            return
        function.compile()


def compile_missing(progress: Callable[[int, int, str], None]) -> None:
    """Compile every function imported so far that is not in the cache; the others are loaded when they are called.

    `progress(done, total, name)` is called before each that is compiled, with the number of these.
    """
    missing = [function for function in tuple(_compiled_functions) if not function.is_cached()]
    for done, function in enumerate(missing):
        progress(done, len(missing), function.name)
        function.compile()


def compile_all(progress: Callable[[int, int, str], None]) -> tuple[str, ...]:
    """Compile or load every compiled function imported so far, and return the names of those compiled anew.

    `progress(done, total, name)` is called before each that is compiled; a warm start calls it never.
    """
    compile_missing(progress)
    return tuple(function.name for function in tuple(_compiled_functions) if function.compile())
