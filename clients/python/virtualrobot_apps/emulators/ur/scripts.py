"""Scripts that clients upload: run by their language."""

from __future__ import annotations

from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.urscript.robot import ScriptProgram
from virtualrobot_apps.languages.urscript.task import load


def run_script(controller: Controller, text: str) -> None:
    """Run a script: in place of the one that runs, or, if it is secondary, at once and beside it.

    What is wrong with it is told as the controller tells it, with its line, and then the one that runs goes on.
    """
    try:
        loaded = load(text)
    except ProgramError as error:
        first = error.diagnostics[0]
        controller.say(210, 0, f"syntax_error_on_line:{first.line}: {first.message}")
        return
    program = ScriptProgram(loaded, controller)
    if not loaded.secondary:
        if refused := controller.play(program):
            controller.say(0, 0, refused)
        else:
            controller.begun(program)
        return
    if program.cycle(controller):
        controller.say(210, 0, f"the secondary program {loaded.name!r} takes time, and was ended where it waited")
    program.close()
