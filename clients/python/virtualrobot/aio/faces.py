"""Faces: the objects of the client library as tasks of asyncio see them, made of the library's own classes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from functools import partial, wraps
from importlib import import_module
from types import FunctionType, TracebackType
from typing import Any, cast

from virtualrobot.aio.orders import Order, Workers

CLASSES = (
    *("cell:Cell", "clock:Clock", "clock:ClockHold", "connection:Client", "drivers:Drivers", "leases:Lease"),
    *("physics:Physics", "plugins:Plugins", "records:Records", "records:RecordHold", "records:RecordWatch"),
    *("tasks:Tasks", "signals:Signals", "signals:SignalWatch", "tokens:Tokens"),
    "files.assets:Assets",
    *("collisions.allowed_pairs:AllowedPairs", "collisions.collisions:Collisions", "history.history:History"),
    *("motions.motion:Motion", "motions.paths:FreePath", "motions.paths:Paths", "motions.program:Program"),
    *("motions.proposals:Proposals", "motions.proposals:ProposalWatch"),
    *("motions.tool_path_parts:ToolPathPart", "motions.tool_paths:ToolPath"),
    *("motions.setpoints:SetpointStream", "recording.recording:Recording", "robots.calibration:Calibration"),
    *("robots.group:Group", "robots.odometry:Odometry", "robots.postures:Postures", "robots.robot:Robot"),
    *("robots.robots:Robots", "robots.tool:Tool", "robots.ways:Way", "scene.editor:Batch", "scene.node:Node"),
    *("scene.scene:Scene", "scene.target:Target", "scene.viewpoint:Viewpoint"),
    *("sensors.rays:Rays", "sensors.sensors:Sensor"),
    *("sensors.sensors:Sensors", "streams.publishing:Publisher", "streams.streams:Streams"),
    *("streams.watch:StreamWatch", "view.film:FilmThread", "view.pictures:Recording", "view.view:View"),
)
"""Classes of the library whose objects ask the kernel."""

RENAMED = {"virtualrobot.view.pictures": {"Recording": "PictureRecording"}}
"""Names of faces, by module, whose own name another one has."""

KEPT = {
    "Client": ("program",),
    "Group": ("calibration",),
    "Lease": ("id", "lost", "owner", "robots", "since"),
    "Motion": ("id", "planned_duration", "robots"),
    "Robot": ("calibration", "postures"),
    "Scene": ("allowed_pairs", "warnings"),
    "SetpointStream": ("state",),
}
"""Functions and properties that only tell what is known: they are as in the library."""

ASKING = {"Batch": (), "Program": ("check", "plan", "start"), "Way": ("check", "plan", "start")}
"""Classes whose objects collect something, and the functions of them that ask; all others are as in the library."""

LEFT_OUT = ("services",)
"""Attributes that faces do not have: stubs would stop the event loop. Of dictionaries they have items alone."""

_END = object()


class Face:
    """Object of the client library as tasks see it: what asks the kernel is an `Order`, to be awaited.

    Attributes that are kept are as they are there. A property that can be set has a function: `set_speed_factor` sets
    `speed_factor`. It is a context manager, or a sequence of events, where the library's object is.
    """

    def __init__(self, one: Any, workers: Workers) -> None:  # noqa: ANN401 an object of one of `CLASSES`
        """Show an object of the library, whose orders these threads do."""
        self._one, self._workers, self._steps = one, workers, None

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 whatever the object has
        """Return what the object keeps."""
        if name.startswith("_") or name in LEFT_OUT or callable(getattr(type(self._one), name, None)):
            raise AttributeError(f"{type(self).__name__!r} of virtualrobot.aio has no {name!r}", name=name, obj=self)
        return faced(getattr(self._one, name), self._workers)

    async def __aenter__(self) -> Any:  # noqa: ANN401 mostly itself
        """Enter it."""
        return await _asked(self._workers, self._one.__enter__)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        """Leave it."""
        return cast("bool | None", await self._workers.do(partial(self._one.__exit__, kind, error, trace)))

    def __aiter__(self) -> Face:
        """Return itself, at its beginning."""
        self._steps = None
        return self

    async def __anext__(self) -> Any:  # noqa: ANN401 whatever it tells
        """Return the next that it tells."""
        one = await self._workers.do(self._next)
        if one is _END:
            raise StopAsyncIteration
        return faced(one, self._workers)

    def _next(self) -> Any:  # noqa: ANN401
        if self._steps is None:
            self._steps = iter(self._one)
        return next(self._steps, _END)

    def __repr__(self) -> str:
        """Return a line for people, without asking the kernel."""
        name = getattr(self._one, "name", getattr(self._one, "id", None))
        return f"<aio.{type(self).__name__}{'' if name is None else f' {name!r}'}>"


def faced(value: Any, workers: Workers) -> Any:  # noqa: ANN401
    """Return a value with a face for each object of the library in it; others are as they are."""
    if isinstance(value, list | tuple) and type(value) in (list, tuple):
        return type(value)(faced(one, workers) for one in value)
    if type(value) is dict:
        return {name: faced(one, workers) for name, one in value.items()}
    face = next((_FACES[kind] for kind in type(value).__mro__ if kind in _FACES), None)
    if face is not None:
        return face(value, workers)
    if isinstance(value, AbstractContextManager) or hasattr(value, "__next__"):
        return Face(value, workers)
    return value


def bare(value: Any) -> Any:  # noqa: ANN401
    """Return an argument as the library takes it: without faces."""
    if isinstance(value, Face):
        return value._one
    if type(value) in (list, tuple, set):
        return type(value)(map(bare, value))
    if type(value) is dict:
        return {name: bare(one) for name, one in value.items()}
    return value


async def _asked(workers: Workers, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:  # noqa: ANN401
    """Return what a function of the library returns, with faces."""
    return faced(await workers.do(partial(function, *bare(arguments), **bare(options))), workers)


def _function(function: FunctionType) -> Callable[..., Any]:
    """Return the function of a face that orders what one of the library does."""

    @wraps(function)
    def order(self: Face, *arguments: Any, **options: Any) -> Order[Any]:  # noqa: ANN401 as `function` has them
        return Order(partial(_asked, self._workers, partial(function, self._one), *arguments, **options), name)

    name = function.__qualname__
    return order


def _kept_function(function: FunctionType) -> Callable[..., Any]:
    """Return the function of a face that asks nobody."""

    @wraps(function)
    def call(self: Face, *arguments: Any, **options: Any) -> Any:  # noqa: ANN401
        return faced(function(self._one, *bare(arguments), **bare(options)), self._workers)

    return call


def _property(kind: type, name: str, own: property) -> property:
    """Return the property of a face, an order of what one of the library tells."""

    def order(self: Face) -> Order[Any]:
        return Order(partial(_asked, self._workers, getattr, self._one, name), f"{kind.__name__}.{name}", is_told=False)

    return property(order, doc=own.__doc__)


def _kept_property(name: str, own: property) -> property:
    """Return the property of a face that asks nobody."""
    return property(lambda self: faced(getattr(self._one, name), self._workers), doc=own.__doc__)


def _setter(kind: type, name: str, own: property) -> Callable[..., Any]:
    """Return the function that sets a property."""

    def order(self: Face, value: Any) -> Order[Any]:  # noqa: ANN401
        set_it = partial(setattr, self._one, name)
        return Order(partial(_asked, self._workers, set_it, value), order.__qualname__)

    order.__name__, order.__qualname__ = f"set_{name}", f"{kind.__name__}.set_{name}"
    order.__doc__ = f"Set `{name}`: {own.__doc__}"
    return order


def is_kept(kind: type, name: str) -> bool:
    """Return whether a function or property of a class of the library asks nobody."""
    if kind.__name__ in ASKING:
        return name not in ASKING[kind.__name__]
    return name in KEPT.get(kind.__name__, ())


def own_members(kind: type) -> dict[str, FunctionType | property]:
    """Return the functions and properties of a class of the library that its face has, by name."""
    shown = ("__call__", "__getitem__", "__len__") if kind.__name__ in ASKING else ("__call__", "__getitem__")
    every = {name: (base, member) for base in reversed(kind.__mro__) for name, member in vars(base).items()}
    return {
        name: member
        for name, (base, member) in every.items()
        if isinstance(member, FunctionType | property)
        and (name in shown or not name.startswith("_"))
        and name not in LEFT_OUT
        and base.__module__ != "collections.abc"
    }


def _face(kind: type) -> type[Face]:
    """Return the face of a class of the library."""
    members: dict[str, Any] = {}
    for name, member in own_members(kind).items():
        kept = is_kept(kind, name)
        if isinstance(member, FunctionType):
            members[name] = _kept_function(member) if kept else _function(member)
            continue
        members[name] = _kept_property(name, member) if kept else _property(kind, name, member)
        if member.fset is not None:
            members.setdefault(f"set_{name}", _setter(kind, name, member))
    return type(name_of(kind), (Face,), {"__doc__": kind.__doc__, "__module__": "virtualrobot.aio", **members})


def name_of(kind: type) -> str:
    """Return the name of the face of a class of the library."""
    return RENAMED.get(kind.__module__, {}).get(kind.__name__, kind.__name__)


def classes() -> Iterator[type]:
    """Yield the classes of the library that have faces."""
    for place in CLASSES:
        module, name = place.split(":")
        yield getattr(import_module(f"virtualrobot.{module}"), name)


_FACES = {kind: _face(kind) for kind in classes()}
BY_NAME = {face.__name__: face for face in _FACES.values()}
"""Faces by their names, such as `Robot`."""
