"""A script that runs on an emulated controller, whose robot it moves."""

from __future__ import annotations

from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.moves import Move
from virtualrobot_apps.languages.urscript.connections import Connections
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.task import Loaded, ScriptTask, Thread


class RobotTask(ScriptTask):
    """A script at work on a controller.

    Attributes:
        controller: the controller.
        connections: its sockets.
    """

    def __init__(self, loaded: Loaded, controller: Controller) -> None:
        """Begin before the first statement."""
        super().__init__(loaded, controller.dt, controller.log)
        self.controller = controller
        self.connections = Connections()
        self._move: Move | None = None
        self._mover: Thread | None = None

    def moves(self, move: Move) -> None:
        """Have the controller make a move, which is the current thread's."""
        self.controller.move = self._move = move
        self._mover = self.thread

    def killed(self, thread: Thread) -> None:
        """Stop the robot where the thread has moved it."""
        if thread is self._mover and self._move is self.controller.move:
            self.controller.halt()


class ScriptProgram:
    """A script as a program of a controller."""

    def __init__(self, loaded: Loaded, controller: Controller) -> None:
        """Begin before the first statement."""
        self.name = loaded.name
        self._task = RobotTask(loaded, controller)

    def cycle(self, controller: Controller) -> bool:
        """Do what the script does in one cycle; return whether it goes on."""
        try:
            return self._task.cycle()
        except ScriptFault as fault:
            controller.say(255, 0, str(fault))
            return False

    def close(self) -> None:
        """Close the script's connections."""
        self._task.connections.close()
