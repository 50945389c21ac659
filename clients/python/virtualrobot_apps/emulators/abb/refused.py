"""Refusals of an emulated ABB controller: a return code of RobotWare, an HTTP status, and words."""

from __future__ import annotations

RETURN_CODES = {
    "SYS_CTRL_E_INVALIDARG": -1073445879,
    "SYS_CTRL_E_MAX_LIMIT_REACHED": -1073445871,
    "SYS_CTRL_E_UNRESOLVED_URL": -1073445866,
    "SYS_CTRL_E_NAMEEXIST": -1073445839,
    "SYS_CTRL_E_NO_SUCH_SYMBOL": -1073442816,
    "SYS_CTRL_E_EXEC_STATE": -1073442809,
    "SYS_CTRL_E_RAPID_SYNTAX_ERROR": -1073442803,
    "SYS_CTRL_E_SYMBOL_NOT_PERSISTENT": -1073442786,
    "SYS_CTRL_E_NO_PP": -1073442783,
    "SYS_CTRL_E_FILE_NOT_FOUND": -1073438708,
    "SYS_CTRL_E_NO_SUCH_MECHUNIT": -1073436668,
    "SYS_CTRL_E_MECSTA_NOT_READY": -1073436650,
    "SYS_CTRL_E_QUEUEFULL": -1073435903,
    "SYS_CTRL_E_FAIL": -1073414146,
}
"""Return codes that are used here, by name (ABB, *Robot Web Services*, 3HAC050973, Robot controller return codes).

A queue whose name is taken answers INVALIDARG, as clients of message queues expect.
"""


class Refused(Exception):
    """A call that is not done: the name of its return code, the HTTP status, and what is wrong in words."""

    def __init__(self, name: str, words: str, status: int = 400) -> None:
        """Keep them."""
        super().__init__(words)
        self.code, self.words, self.status = RETURN_CODES[f"SYS_CTRL_E_{name}"], words, status


def unknown(what: str, name: str, known: list[str] | tuple[str, ...], code: str = "INVALIDARG") -> Refused:
    """Return the refusal of a name that isn't one of those that are known."""
    return Refused(code, f"there is no {what} {name!r}; there are: {', '.join(known) or 'none'}", 404)
