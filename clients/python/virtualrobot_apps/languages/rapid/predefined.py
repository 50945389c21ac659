"""Data that RAPID has before any program: speeds, zones, tool0, wobj0, numbers of errors.

Speeds and zones are those of ABB, *Technical reference manual, RAPID Instructions, Functions and Data types*
(3HAC050917): *speeddata* and *zonedata*, predefined data. Lengths in mm, speeds in mm/s, angles in degrees.
"""

from __future__ import annotations

import math
from typing import Any

SPEEDS = (
    *(5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800),
    *(1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000),
)
"""Speeds of the tool centre point of v5 to v7000, mm/s; all turn at 500 degrees/s."""

ZONES = {
    0: (0.3, 0.3, 0.3, 0.03, 0.3, 0.03),
    1: (1.0, 1.0, 1.0, 0.1, 1.0, 0.1),
    5: (5.0, 8.0, 8.0, 0.8, 8.0, 0.8),
    10: (10.0, 15.0, 15.0, 1.5, 15.0, 1.5),
    15: (15.0, 23.0, 23.0, 2.3, 23.0, 2.3),
    20: (20.0, 30.0, 30.0, 3.0, 30.0, 3.0),
    30: (30.0, 45.0, 45.0, 4.5, 45.0, 4.5),
    40: (40.0, 60.0, 60.0, 6.0, 60.0, 6.0),
    50: (50.0, 75.0, 75.0, 7.5, 75.0, 7.5),
    60: (60.0, 90.0, 90.0, 9.0, 90.0, 9.0),
    80: (80.0, 120.0, 120.0, 12.0, 120.0, 12.0),
    100: (100.0, 150.0, 150.0, 15.0, 150.0, 15.0),
    150: (150.0, 225.0, 225.0, 23.0, 225.0, 23.0),
    200: (200.0, 300.0, 300.0, 30.0, 300.0, 30.0),
}
"""Zones z0 to z200: path of the tool centre point, of its orientation, of external axes; orientation, external axes."""

NO_AXIS = 9e9
"""Value of an external axis that is not there."""

ERRORS = (
    *(
        "ERR_DIVZERO",
        "ERR_OUTOFBND",
        "ERR_STRTOOLNG",
        "ERR_ARGVALERR",
        "ERR_REFUNKPRC",
        "ERR_REFUNKDAT",
        "ERR_ILLRAISE",
    ),
    *("ERR_WAIT_MAXTIME", "ERR_ROBLIMIT", "ERR_NORETURN", "ERR_UNKPROC", "ERR_CALLPROC", "ERR_NOTPRES", "ERR_INVDIM"),
    *("ERR_UNKINO", "ERR_INOISSAFE"),
    *("ERR_SOCK_CLOSED", "ERR_SOCK_TIMEOUT", "ERR_SOCK_ADDR_INUSE", "ERR_SOCK_CONNREF", "ERR_SOCK_NOTCON"),
    *("ERR_SOCK_ISCON", "ERR_FILEACC", "ERR_FILEEXIST", "ERR_FILEOPEN", "ERR_FILNOTFND", "ERR_RCVDATA"),
    *("ERR_WHLSEARCH", "ERR_SIGSUPSEARCH", "ERR_FRAME"),
    *("ERR_TP_MAXTIME", "ERR_UI_NOACTION", "ERR_UI_MAXMIN", "ERR_UI_INITVALUE", "ERR_RANYBIN_EOF"),
    *("ERR_WAITSYNCTASK", "ERR_UDPUC_COMM"),
)
"""Errors that programs can handle; on a controller their numbers are above 1,000 and named alone."""

OTHER_ERRORS = ("ERR_MOTIONSUP", "ERR_COLL_STOP", "ERR_PATH_STOP", "ERR_NORUNUNIT")
"""Errors of a controller for which handlers of public programs look, and which never come here."""

ERROR_NUMBERS = {name: 1001.0 + number for number, name in enumerate((*ERRORS, *OTHER_ERRORS))}
"""The number of each error here; programs compare ERRNO with the names."""

ALL_ERRORS = 0.0
"""Number of a handler (`ERROR (LONG_JMP_ALL_ERR)`) that handles all errors."""

SOCKET_STATES = ("SOCKET_CREATED", "SOCKET_CONNECTED", "SOCKET_BOUND", "SOCKET_LISTENING", "SOCKET_CLOSED")
"""States of a socket, whose values count from 1 (3HAC050917, socketstatus)."""


LETTERS = "ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚÛÜÝÞ"
"""Large letters of ISO 8859-1 beside A to Z, in the order of STR_UPPER."""

NUMBERS = {
    **{"btnNone": -1, "btnOK": 0, "btnAbrtRtryIgn": 1, "btnOKCancel": 2, "btnRetryCancel": 3, "btnYesNo": 4},
    **{"btnYesNoCancel": 5, "resUnkwn": 0, "resOK": 1, "resAbort": 2, "resRetry": 3, "resIgnore": 4, "resCancel": 5},
    **{"resYes": 6, "resNo": 7, "iconNone": 0, "iconInfo": 1, "iconWarning": 2, "iconError": 3},
    **{"USINT": 1, "UINT": 2, "UDINT": 4, "ULINT": 8, "SINT": -1, "INT": -2, "DINT": -4, "LINT": -8},
    **{"LT": 1, "LTEQ": 2, "EQ": 3, "NOTEQ": 4, "GTEQ": 5, "GT": 6},
    **{"OP_UNDEF": 0, "OP_AUTO": 1, "OP_MAN_PROG": 2, "OP_MAN_TEST": 3},
    **{"RUN_UNDEF": 0, "RUN_CONT_CYCLE": 1, "RUN_INSTR_FWD": 2, "RUN_INSTR_BWD": 3, "RUN_SIM": 4, "RUN_STEP_MOVE": 5},
    **{"EGM_FRAME_BASE": 0, "EGM_FRAME_TOOL": 1, "EGM_FRAME_WOBJ": 2, "EGM_FRAME_WORLD": 3, "EGM_FRAME_JOINT": 4},
    **{"EGM_STOP_HOLD": 0, "EGM_STOP_RAMP_DOWN": 1},
    **{"EGM_STATE_DISCONNECTED": 0, "EGM_STATE_CONNECTED": 1, "EGM_STATE_RUNNING": 2},
}
"""Predefined numbers: buttons, their results, icons, types of integers, comparisons, operating modes (3HAC050917).

Those of running modes, and of EGM's stop modes and states are assumed; public programs compare states by their order.
"""

UNITS = ("ROB_1", "ROB_2", "ROB_3", "ROB_4", "ROB_L", "ROB_R")
"""Names of mechanical units, as controllers of one arm and of several call them."""


def _pose(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> list[Any]:
    return [[x, y, z], [1.0, 0.0, 0.0, 0.0]]


CONSTANTS: dict[str, tuple[str, Any]] = {
    **{f"v{speed}": ("speeddata", [float(speed), 500.0, 5000.0, 1000.0]) for speed in SPEEDS},
    "vmax": ("speeddata", [7000.0, 500.0, 5000.0, 1000.0]),
    "fine": ("zonedata", [True, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    **{f"z{radius}": ("zonedata", [False, *sizes]) for radius, sizes in ZONES.items()},
    "pi": ("num", math.pi),
    "WAIT_MAX": ("num", 9e9),
    "EOF": ("string", "EOF"),
    "stEmpty": ("string", ""),
    "EOF_BIN": ("num", -1.0),
    "EOF_NUM": ("num", 9.998e36),
    "STR_DIGIT": ("string", "0123456789"),
    "STR_UPPER": ("string", f"ABCDEFGHIJKLMNOPQRSTUVWXYZ{LETTERS}"),
    "STR_LOWER": ("string", f"abcdefghijklmnopqrstuvwxyz{LETTERS.lower()}"),
    "STR_WHITE": ("string", " \t\n\v\f\r"),
    **{name: ("num", float(number)) for name, number in NUMBERS.items()},
    **{name: ("mecunit", name) for name in UNITS},
    "high": ("num", 1.0),
    "low": ("num", 0.0),
    "edge": ("num", 2.0),
    **{name: ("num", 1.0 + number) for number, name in enumerate(SOCKET_STATES)},
    **{name: ("num", number) for name, number in ERROR_NUMBERS.items()},
    "LONG_JMP_ALL_ERR": ("num", ALL_ERRORS),
}
"""Type and value of each constant."""

_LOAD = [0.001, [0.0, 0.0, 0.001], [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0]

VARIABLES: dict[str, tuple[str, str, Any]] = {
    "ERRNO": ("var", "num", 0.0),
    "INTNO": ("var", "num", 0.0),
    "tool0": ("pers", "tooldata", [True, _pose(), _LOAD]),
    "load0": ("pers", "loaddata", _LOAD),
    "wobj0": ("pers", "wobjdata", [False, True, "", _pose(), _pose()]),
    **{f"reg{number}": ("var", "num", 0.0) for number in range(1, 6)},
    "clock1": ("var", "clock", None),
}
"""Storage, type and value of data that a program may change; reg1 to reg5 and clock1 are those of the module USER."""
