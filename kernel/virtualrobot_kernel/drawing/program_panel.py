"""Steps of the programs that run, in the panel of the page, with the one that each is at."""

from __future__ import annotations

import viser

from virtualrobot_kernel.world.program_lines import program_lines
from virtualrobot_kernel.world.state import Motion, Snapshot
from virtualrobot_kernel.world.structure import Structure

BEFORE, AFTER = 2, 6
"""Number of steps that are shown before and after the present one."""


class ProgramPanel:
    """Panel of one page: a text for all programs, which is there as long as one runs."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Add the panel to the page, hidden."""
        self._folder = server.gui.add_folder("Programs", visible=False)
        with self._folder:
            self._text = server.gui.add_markdown("")
        self._shown: tuple[object, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        """Show the programs of a snapshot; nothing is sent while they stay at their steps."""
        programs = [motion for motion in snapshot.state.motions if motion.step_count]
        shown = tuple((motion.id, motion.step_path, motion.phase, motion.step_count) for motion in programs)
        if shown == self._shown:
            return
        self._shown = shown
        self._folder.visible = bool(programs)
        self._text.content = "\n\n".join(program_text(snapshot.structure, motion) for motion in programs)


def program_text(structure: Structure, motion: Motion) -> str:
    """Return the steps of a program around the present one as Markdown, a line for each, the present one in bold."""
    robots = ", ".join(structure.nodes[uid].name for uid in motion.robots if uid in structure.nodes)
    text = [f"**{motion.id}** {robots}: {motion.phase.value.lower()}"]
    for line in program_lines(structure, motion, BEFORE, AFTER):
        words = f"{'● ' if line.pauses else ''}`{line.path}` {line.words}"
        text.append(f"▶ **{words}**" if line.now else words)
    return "  \n".join(text)
