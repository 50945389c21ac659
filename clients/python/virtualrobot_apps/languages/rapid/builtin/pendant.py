"""Pendant: lines that are written, and questions, whose answers come from the terminal or from --answer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.core.pendant import NobodyAnswers, Question
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import number_text, value_text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

_ENDS = r"\num MaxTime"
_LACKING = "DIBreak DIPassive DOBreak DOPassive PersBoolBreak PersBoolPassive BreakFlag"
_LINES = r"string MsgLine1 \string MsgLine2 \string MsgLine3 \string MsgLine4 \string MsgLine5"
_MESSAGE = r"\string Header \string Message | string MsgArray{*} \switch Wrap"

_BUTTONS = {
    -1: (),
    0: ("OK",),
    1: ("Abort", "Retry", "Ignore"),
    2: ("OK", "Cancel"),
    3: ("Retry", "Cancel"),
    4: ("Yes", "No"),
    5: ("Yes", "No", "Cancel"),
}
"""Buttons of a dialog, by the values of `buttondata`."""
_RESULTS = {"OK": 1.0, "Abort": 2.0, "Retry": 3.0, "Ignore": 4.0, "Cancel": 5.0, "Yes": 6.0, "No": 7.0}
"""Values of `btnres`."""


@instruction("TPWrite", r"string String \num Num | bool Bool | pos Pos | orient Orient | dnum Dnum")
def _tp_write(task: RapidTask, text: str, *more: Any) -> None:  # noqa: ANN401 values of several types
    """Writes a line on the pendant, with a value behind it."""
    task.settle()
    task.write(text + "".join(value_text(one) for one in more if one is not None))


@instruction("TPErase")
def _tp_erase(task: RapidTask) -> None:
    """Clears the pendant; here what was written stays."""
    task.settle()


@instruction("TPShow", "num Window")
def _tp_show(task: RapidTask, window: float) -> None:
    """Shows a window of the pendant; here there is one alone."""
    task.settle()


@instruction("ErrWrite", r"\switch W | switch I, string Header, string Reason \string RL2 \string RL3 \string RL4")
def _err_write(task: RapidTask, warning: bool | None, information: bool | None, *lines: str | None) -> None:
    """Writes a message of several lines into the log and on the pendant."""
    task.settle()
    kind = "warning" if warning else "information" if information else "error"
    task.report(kind, None, [line for line in lines if line])


@instruction("SkipWarn")
def _skip_warn(task: RapidTask) -> None:
    """Does nothing: the warning that it takes out of a controller's log is not written here."""


@function("UIClientExist", "", "bool")
def _ui_client_exist(task: RapidTask) -> bool:
    """TRUE: somebody answers, or else the question ends the program."""
    return True


def _asked(task: RapidTask, question: str, seconds: float | None, asked: Question | None = None) -> str:
    """Return the answer to a question; ERR_TP_MAXTIME where none comes in time.

    `asked` is the question for those who show its answers beside it.
    """
    task.write(question)
    try:
        asked = asked or Question(question)
        answer = task.pendant.ask(task, asked, None if seconds is None or seconds >= 9e9 else seconds)
    except NobodyAnswers:
        raise RapidStopped(
            f"the program asks {question!r}, and there is no answer: give one by --answer TEXT, or at a terminal"
        ) from None
    if answer is None:
        raise RapidFault("ERR_TP_MAXTIME", f"nobody answered within {seconds:g} s")
    return answer.strip()


def _number(task: RapidTask, question: str, seconds: float | None) -> float:
    """Return the number that is answered; what is none is asked again."""
    while True:
        answer = _asked(task, question, seconds)
        try:
            value = float(answer)
        except ValueError:
            value = math.nan
        if math.isfinite(value):
            return value
        task.write(f"{answer!r} is no number")


def _choice(task: RapidTask, question: str, names: list[tuple[int, str]], seconds: float | None) -> int:
    """Return the number of what is chosen by its name or number; what is not there is asked again."""
    told = ", ".join(name if name == str(number) else f"{number}: {name}" for number, name in names)
    while True:
        asked = Question(question, tuple(name for _, name in names))
        answer = _asked(task, f"{question} [{told}]", seconds, asked)
        for number, name in names:
            if answer in (str(number), name) or answer.lower() == name.lower():
                return number
        task.write(f"{answer!r} is none of them")


@instruction(
    "TPReadFK",
    f"inout num TPAnswer, string TPText, string TPFK1, string TPFK2, string TPFK3, string TPFK4, string TPFK5 {_ENDS}",
    lacking=_LACKING,
)
def _tp_read_fk(task: RapidTask, holder: list[float], index: int, text: str, *more: Any) -> None:  # noqa: ANN401
    """Asks for one of five keys, by the word above it or its number; empty ones are not there."""
    task.settle()
    *keys, seconds = more
    names = [(number, key) for number, key in enumerate(keys, 1) if key]
    if not names:
        raise RapidFault("ERR_ARGVALERR", "TPReadFK needs a word for one of its keys")
    holder[index] = float(_choice(task, text, names, seconds))


@instruction("TPReadNum", f"inout num TPAnswer, string TPText {_ENDS}", lacking=_LACKING)
def _tp_read_num(task: RapidTask, holder: list[float], index: int, text: str, seconds: float | None) -> None:
    """Asks for a number."""
    task.settle()
    holder[index] = _number(task, text, seconds)


@instruction("TPReadDnum", f"inout dnum TPAnswer, string TPText {_ENDS}", lacking=_LACKING)
def _tp_read_dnum(task: RapidTask, holder: list[float], index: int, text: str, seconds: float | None) -> None:
    """Asks for a number, as TPReadNum does."""
    _tp_read_num(task, holder, index, text, seconds)


def _message(header: str | None, text: str | None, lines: list[str] | None) -> str:
    return "\n".join([one for one in (header, text) if one] + [one for one in lines or () if one])


def _pressed(task: RapidTask, text: str, own: list[str] | None, buttons: float | None, seconds: float | None) -> float:
    """Return which button is pressed: the number of one of the program's own, or else of `btnres`."""
    if own:
        return float(_choice(task, text, list(enumerate(own, 1)), seconds))
    names = _BUTTONS.get(int(buttons or 0))
    if names is None:
        raise RapidFault("ERR_ARGVALERR", f"buttons are btnNone to btnYesNoCancel, not {buttons:g}")
    if not names:
        task.write(text)
        return 0.0
    return _RESULTS[names[_choice(task, text, list(enumerate(names, 1)), seconds) - 1]]


@instruction(
    "UIMsgBox",
    rf"\string Header, {_LINES} \switch Wrap \buttondata Buttons \icondata Icon \string Image "
    rf"\inout btnres Result {_ENDS}",
    lacking=_LACKING,
)
def _ui_msg_box(task: RapidTask, header: str | None, *more: Any) -> None:  # noqa: ANN401
    """Shows lines until a button is pressed, by its name or number: OK, or those of Buttons."""
    task.settle()
    *lines, _wrap, buttons, _icon, _image, result, index, seconds = more
    pressed = _pressed(task, _message(header, None, lines), None, buttons, seconds)
    if result is not None:
        result[index] = pressed


@function(
    "UIMessageBox",
    rf"{_MESSAGE} \buttondata Buttons | string BtnArray{{*}} \num DefaultBtn \icondata Icon \string Image {_ENDS}",
    "btnres",
    lacking=_LACKING,
)
def _ui_message_box(
    task: RapidTask,
    header: str | None,
    text: str | None,
    lines: list[str] | None,
    wrap: bool | None,
    buttons: float | None,
    own: list[str] | None,
    default: float | None,
    icon: float | None,
    image: str | None,
    seconds: float | None,
) -> float:
    """Button that is pressed: a number of `btnres`, or that of one of BtnArray; DefaultBtn when nobody does in time."""
    task.settle()
    try:
        return _pressed(task, _message(header, text, lines), own, buttons, seconds)
    except RapidFault as fault:
        if default is None or fault.name != "ERR_TP_MAXTIME":
            raise
        return default


@function(
    "UINumEntry",
    rf"{_MESSAGE} \icondata Icon \num InitValue \num MinValue \num MaxValue \switch AsInteger {_ENDS}",
    "num",
    lacking=_LACKING,
)
def _ui_num_entry(
    task: RapidTask,
    header: str | None,
    text: str | None,
    lines: list[str] | None,
    wrap: bool | None,
    icon: float | None,
    first: float | None,
    least: float | None,
    most: float | None,
    whole: bool | None,
    seconds: float | None,
) -> float:
    """Number that is entered, within its bounds; an empty answer is InitValue."""
    task.settle()
    low, high = -math.inf if least is None else least, math.inf if most is None else most
    if low > high:
        raise RapidFault("ERR_UI_MAXMIN", f"MinValue {low:g} is above MaxValue {high:g}")
    if first is not None and not (low <= first <= high and (not whole or first == int(first))):
        raise RapidFault("ERR_UI_INITVALUE", f"InitValue {first:g} is not allowed itself")
    bounds = [f"from {number_text(low)}"] * (least is not None) + [f"to {number_text(high)}"] * (most is not None)
    bounds += [f"empty: {number_text(first)}"] if first is not None else []
    question = _message(header, text, lines) + (f" [{', '.join(bounds)}]" if bounds else "")
    while True:
        answer = _asked(task, question, seconds)
        try:
            value = first if not answer and first is not None else float(answer)
        except ValueError:
            value = math.nan
        if low <= value <= high and math.isfinite(value) and (not whole or value == int(value)):
            return value
        task.write(f"{answer!r} is no {'whole ' if whole else ''}number that is allowed")


@function("UIAlphaEntry", rf"{_MESSAGE} \icondata Icon \string InitString {_ENDS}", "string", lacking=_LACKING)
def _ui_alpha_entry(
    task: RapidTask,
    header: str | None,
    text: str | None,
    lines: list[str] | None,
    wrap: bool | None,
    icon: float | None,
    first: str | None,
    seconds: float | None,
) -> str:
    """Text that is entered, 80 characters at most; an empty answer is InitString."""
    task.settle()
    question = _message(header, text, lines) + (f" [empty: {first}]" if first else "")
    while True:
        answer = _asked(task, question, seconds) or first or ""
        if len(answer) <= 80:
            return answer
        task.write(f"a string has at most 80 characters, and this has {len(answer)}")


@function(
    "UIListView",
    rf"\inout btnres Result \string Header, listitem ListItems{{*}} \buttondata Buttons \icondata Icon "
    rf"\num DefaultIndex {_ENDS}",
    "num",
    lacking=f"{_LACKING} BtnArray",
)
def _ui_list_view(
    task: RapidTask,
    result: list[float] | None,
    index: int,
    header: str | None,
    items: list[list[str]],
    buttons: float | None,
    icon: float | None,
    default: float | None,
    seconds: float | None,
) -> float:
    """Number of the item that is chosen, by its text or number; the button is then the first one of Buttons."""
    task.settle()
    names = [(number, text) for number, (_, text) in enumerate(items, 1)]
    try:
        chosen = float(_choice(task, header or "choose", names, seconds))
    except RapidFault as fault:
        if default is None or fault.name != "ERR_TP_MAXTIME":
            raise
        chosen = default
    if result is not None:
        first = (*_BUTTONS.get(int(buttons or 0), ()), "OK")[0]
        result[index] = _RESULTS[first]
    return chosen
