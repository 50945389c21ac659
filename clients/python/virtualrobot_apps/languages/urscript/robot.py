"""A script that runs on an emulated controller, whose robot it moves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from virtualrobot.connection import Client

from virtualrobot_apps.emulators.ur.compliance import USUAL_DAMPING
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.moves import Move
from virtualrobot_apps.languages.core.pendant import Pendant
from virtualrobot_apps.languages.core.published import Label, Published
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.urscript.connections import Connections
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.task import Loaded, ScriptTask, Thread


class RobotTask(ScriptTask):
    """A script at work on a controller.

    Attributes:
        controller: the controller.
        connections: its sockets.
        damping, gain: of its force mode.
    """

    def __init__(self, loaded: Loaded, controller: Controller) -> None:
        """Begin before the first statement."""
        super().__init__(loaded, controller.dt, controller.log)
        self.controller = controller
        self.connections = Connections()
        self.damping, self.gain = USUAL_DAMPING, 1.0
        self._move: Move | None = None
        self._mover: Thread | None = None
        self._blending: Move | None = None
        self._holder: Thread | None = None

    @contextmanager
    def controls(self) -> Iterator[None]:
        """Have the current thread control the robot as long as a function of motion lasts: no other one may."""
        if self._holder is not None and not self._holder.over:
            raise ScriptFault(f"Another thread is already controlling the robot: {self._holder.name!r}")
        holder = self._holder = self.thread
        try:
            yield
        finally:
            if self._holder is holder:
                self._holder = None

    def moves(self, move: Move) -> None:
        """Have the controller make a move, which is the current thread's."""
        if self.loaded.secondary:
            raise ScriptFault("a secondary program (sec) can't move the robot")
        self.controller.move = self._move = move
        self._mover, self._blending = self.thread, None

    def blend(self, move: Move) -> None:
        """Let the next move join this one, which has come within the radius of its blend."""
        self._blending = move

    @property
    def blending(self) -> Move | None:
        """Move that the next one may join; None where there is none, or it has come to its end."""
        return self._blending if self._blending is self.controller.move else None

    def shown(self, words: str) -> Iterator[None]:
        """Wait until the controller's dashboard, or an order, has closed a popup."""
        if not self.controller.attended:
            yield from super().shown(words)
        self.controller.popup = True
        while self.controller.popup:
            yield

    def killed(self, thread: Thread) -> None:
        """Stop the robot where the thread has moved it."""
        if thread is self._mover and self._move is self.controller.move:
            self.controller.halt()


class ScriptProgram:
    """A script as a program of a controller; `task` is the script at work."""

    def __init__(self, loaded: Loaded, controller: Controller, kind: type[RobotTask] = RobotTask) -> None:
        """Begin before the first statement, with a task of a kind."""
        self.name = loaded.name
        self.task = kind(loaded, controller)
        self._stopped = ""
        self._fault: ScriptFault | None = None
        self._told: Published | None = None

    def tell(self, client: Client, robot: str) -> None:
        """Have everybody see and stop it, until it is closed."""
        pendant = Pendant(self.task.write)
        self.task.write = pendant.write
        label = Label(self.name, "URScript", [self.task.loaded.source.file], robot)
        self._told = Published(client, self, pendant, label)

    def program_pointer(self) -> str:
        """Return file and line of the statement that is done."""
        return self.task.pointer()

    def motion_pointer(self) -> str:
        """Return the same where a move is made: a script waits for each."""
        return self.task.pointer() if self.task.controller.move is not None else ""

    def stop(self, why: str = "stopped") -> None:
        """End it with the next cycle; any thread may call it."""
        self._stopped = why
        self.task.controller.paused = False  # what is paused has no cycles

    def cycle(self, controller: Controller) -> bool:
        """Do what the script does in one cycle; return whether it goes on.

        A cycle that ends by a fault sets no registers: a client that reads them must not take it for done.
        """
        if self._stopped:
            controller.say(0, 0, self._stopped)
            return False
        before = dict(controller.registers)
        try:
            # The last move goes to its end, whatever its radius.
            return self.task.cycle() or self.task.blending is not None
        except ScriptFault as fault:
            controller.registers = before
            controller.say(255, 0, str(fault))
            self._fault = fault
            return False

    def close(self) -> None:
        """Close the script's connections."""
        self.task.connections.close()
        if self._told is not None:
            self._told.close(TaskStopped(self._stopped) if self._stopped else self._fault)
