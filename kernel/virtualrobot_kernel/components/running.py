"""Components at work: in this process, or in a worker process with a deadline for each call."""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Protocol

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.settings import make_settings
from virtualrobot_sdk.worker import Worker
from virtualrobot_sdk.worker.blame import describe_error, package_of, traceback_of

from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.lateness import Aside, Late, awaited, may_be_late

START_SECONDS = 20.0
"""Deadline (s) for importing and making a component in a process of its own."""

MOST_LATE = 64
"""Greatest number of late answers that are kept for whoever asks again."""

HUNG_SECONDS = 20.0
"""Time (s) after which a call that has not returned counts as hung where nothing can end it: in this process."""


class Instance(Protocol):
    """Answerer of the calls of one component."""

    @property
    def process_id(self) -> int:
        """Return the number of its process; 0 for this one."""
        ...

    @property
    def is_in_process(self) -> bool:
        """True where it runs in this process."""
        ...

    def has(self, method: str) -> bool:
        """Return whether the component has a method that not all of its kind have; one in another process has none."""
        ...

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  what a method returns is its own matter
        """Return what the component's method returns.

        Raises ArgumentError and FilesNeeded as the component does, and ComponentFault for whatever else goes wrong.
        """
        ...

    @property
    def has_ended(self) -> bool:
        """True once a fault has ended its process."""
        ...

    def close(self) -> None:
        """End the component."""
        ...


class ComponentHandle:
    """Component at work for somebody: counts its calls, and keeps its faults.

    A fault refuses the call in which it happens. One that ended the component's process (it hung, crashed or grew) is
    kept as `fault`, and the component is not asked again; whoever has it may make another.
    """

    def __init__(self, offer: Offer, instance: Instance, user: str) -> None:
        """Take an instance of what a plugin offers; `user` is whom it works for, in words for errors."""
        self.offer = offer
        self.fault: ComponentFault | None = None
        """Fault that ended its process; None while it runs."""
        self.calls = 0
        self._latest: ComponentFault | None = None
        self._under_way: dict[object, tuple[str, float]] = {}
        self._seconds = 0.0
        self._instance = instance
        self._user = user
        self._lock = threading.Lock()
        self._aside: Aside | None = None
        self._late: dict[bytes, Future[Any]] = {}
        """Answers that were late, by what was asked."""

    @property
    def process_id(self) -> int:
        """Return the number of its process; 0 for this one."""
        return self._instance.process_id

    @property
    def latest(self) -> ComponentFault | None:
        """Return the latest fault of any kind, or that it hangs in this process; None without one."""
        return self.hung or self._latest

    @property
    def hung(self) -> ComponentFault | None:
        """Return the fault of a component in this process one of whose calls does not return."""
        if not self._instance.is_in_process:
            return None
        with self._lock:
            calls = tuple(self._under_way.values())
        for method, started in calls:
            if (seconds := time.perf_counter() - started) > HUNG_SECONDS:
                said = f"{method} has not returned for {seconds:.0f} s; in its own process the kernel cannot end it"
                return ComponentFault(FaultKind.HUNG, said)
        return None

    @property
    def mean_seconds(self) -> float:
        """Return the mean time of a call; 0 before the first."""
        return self._seconds / self.calls if self.calls else 0.0

    def has(self, method: str) -> bool:
        """Return whether the component has a method that not all of its kind have; one in another process has none."""
        return self._instance.has(method)

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  what a method returns is its own matter
        """Return what the component's method returns.

        Raises FilesNeeded; KernelError with the component's own words for what it refuses, and PLUGIN_FAILED for a
        fault, now or earlier, and for one in this process while another call hangs. Within `patiently`, and of a
        component in a process of its own, Late where its answer does not come at once: the same question has it then.
        """
        if may_be_late() and not self._instance.is_in_process:
            return self._patiently_called(method, arguments)
        return self._called(method, arguments)

    def _patiently_called(self, method: str, arguments: tuple[object, ...]) -> Any:  # noqa: ANN401
        asked = pickle.dumps((method, arguments)) if self._late else b""
        answer = self._late.get(asked)
        if answer is None:
            self._aside = self._aside or Aside(f"component {self.offer.about.name}")
            answer = self._aside.ask(lambda: self._called(method, arguments))
        try:
            return awaited(answer)
        except Late:
            while len(self._late) >= MOST_LATE:
                del self._late[next(iter(self._late))]
            self._late[asked or pickle.dumps((method, arguments))] = answer
            raise

    def _called(self, method: str, arguments: tuple[object, ...]) -> Any:  # noqa: ANN401
        if (fault := self.fault or self.hung) is not None:
            raise self.failed(fault)
        started = time.perf_counter()
        with self._lock:
            self._under_way[this := object()] = method, started
        try:
            answer = self._instance.call(method, *arguments)
        except ArgumentError as error:
            raise refusal_of(str(error), error) from error
        except FilesNeeded as error:
            if self.offer.about.kind is ComponentKind.IMPORTER:
                raise
            raise self.failed(_fault(error)) from error
        except (PluginError, ComponentFault) as error:
            raise self.failed(_fault(error)) from error
        finally:
            with self._lock:
                del self._under_way[this]
                self.calls += 1
                self._seconds += time.perf_counter() - started
        return answer

    def failed(self, fault: ComponentFault) -> KernelError:
        """Keep a fault and return the error that tells of it."""
        # Without its traceback, whose frames would keep the caller, and so this component, alive.
        self._latest = ComponentFault(fault.kind, fault.reason, fault.details)
        if self.fault is None and self._instance.has_ended:
            self.fault = self._latest
            self._instance.close()
        return plugin_failed(self.offer, self._user, fault)

    def close(self) -> None:
        """End the component."""
        self._instance.close()
        if self._aside is not None:
            self._aside.close()


def plugin_failed(offer: Offer, user: str, fault: ComponentFault) -> KernelError:
    """Return the error that tells of a component's fault."""
    return KernelError(
        f"the {offer.about.kind.value} component {offer.about.name!r}{user} failed: {fault.reason}",
        reason=Reason.PLUGIN_FAILED,
        component=offer.about.name,
        fault=fault.kind.value,
        details=fault.details,
    )


def start(offer: Offer, settings: Mapping[str, Any], *arguments: object, user: str = "") -> ComponentHandle:
    """Make a component: `factory(*arguments)`, with settings where it has any; `user` is whom it works for.

    Raises KernelError with the component's own words for settings or arguments that it refuses; PLUGIN_FAILED when it
    can't be made.
    """
    in_process = offer.register is not None and offer.about.isolation is Isolation.IN_PROCESS
    try:
        instance = _InProcess(offer, settings, arguments) if in_process else _InWorker(offer, settings, arguments)
    except ArgumentError as error:
        raise refusal_of(f"{offer.about.kind.value} component {offer.about.name!r}: {error}", error) from error
    except (FilesNeeded, PluginError, ComponentFault) as error:
        raise plugin_failed(offer, user, _fault(error)) from error
    return ComponentHandle(offer, instance, user)


def refusal_of(message: str, error: ArgumentError) -> KernelError:
    """Return a component's refusal; its metadata may have any names, those of our own arguments too."""
    refusal = KernelError(message)
    refusal.metadata.update(error.metadata)
    return refusal


def _fault(error: FilesNeeded | PluginError | ComponentFault) -> ComponentFault:
    """Return what a component did wrong that raised this where it may not."""
    if isinstance(error, ComponentFault):
        return error
    if isinstance(error, FilesNeeded):
        names = ", ".join(map(str, error.names))
        said = f"it asks for files ({names}); only an importer's translate may do that"
        return ComponentFault(FaultKind.RAISED, said)
    return ComponentFault(FaultKind.RAISED, str(error))


class _InProcess:
    """Component in this process."""

    process_id = 0
    is_in_process = True
    has_ended = False

    def __init__(self, offer: Offer, settings: Mapping[str, Any], arguments: tuple[object, ...]) -> None:
        assert offer.register is not None
        one = offer.register()
        self._package = package_of(offer.entry_point.value)
        chosen = make_settings(one.config_type, settings)
        given = arguments if one.config_type is None else (*arguments, chosen)
        self._component = self._contained(lambda: one.factory(*given))

    def has(self, method: str) -> bool:
        return self._contained(lambda: callable(getattr(self._component, method, None)))

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401
        def asked() -> Any:  # noqa: ANN401
            value = getattr(self._component, method)
            return value(*arguments) if callable(value) else value

        return self._contained(asked)

    def close(self) -> None:
        pass

    def _contained(self, function: Callable[[], Any]) -> Any:  # noqa: ANN401
        try:
            return function()
        except (ArgumentError, FilesNeeded, PluginError):
            raise
        except BaseException as error:
            # Also SystemExit, which would end the thread of the API.
            reason = describe_error(error, self._package)
            raise ComponentFault(FaultKind.RAISED, reason, traceback_of(error)) from error


class _InWorker:
    """Component in a process of its own."""

    is_in_process = False

    def __init__(self, offer: Offer, settings: Mapping[str, Any], arguments: tuple[object, ...]) -> None:
        self._deadline = offer.about.deadline_seconds
        self._worker = Worker(f"{offer.about.kind.value} {offer.about.name}")
        try:
            self._worker.make(
                offer.entry_point,
                offer.about.kind,
                offer.about.name,
                settings,
                *arguments,
                deadline_seconds=START_SECONDS,
            )
        except BaseException:
            self._worker.close()
            raise

    @property
    def process_id(self) -> int:
        return self._worker.pid or 0

    @property
    def has_ended(self) -> bool:
        return self._worker.fault is not None

    def has(self, method: str) -> bool:
        return False

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401
        return self._worker.call(method, *arguments, deadline_seconds=self._deadline)

    def close(self) -> None:
        self._worker.close()
