"""Files: text and bytes below the one folder that a program may use, whatever disk it names."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

from virtualrobot_apps.languages.core.files import FileRefused, below
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS
from virtualrobot_apps.languages.rapid.support import joined
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import FileDevice, FolderDevice, value_text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

LONGEST_TEXT = 80
_EOF, _EOF_BIN, _EOF_NUM = (CONSTANTS[name][1] for name in ("EOF", "EOF_BIN", "EOF_NUM"))
_NUMBER = re.compile(rb"[ \t\r\n]*([-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?)")
_Result = TypeVar("_Result")


def _place(task: RapidTask, name: str) -> Path:
    """Return where a name is; raises a fault where the program may use no files, or not this one."""
    if task.files is None:
        raise RapidStopped(f"the program wants the file {name!r}: allow it a folder by --files FOLDER")
    try:
        return below(task.files, name)
    except FileRefused as error:
        raise RapidFault("ERR_FILEACC", str(error)) from error


def _done(what: Callable[[], _Result], name: str) -> _Result:
    """Return what a call of the system gives; what it refuses is a fault."""
    try:
        return what()
    except FileNotFoundError as error:
        raise RapidFault("ERR_FILNOTFND", f"there is no {name!r}") from error
    except FileExistsError as error:
        raise RapidFault("ERR_FILEEXIST", f"{name!r} is there already") from error
    except (OSError, shutil.Error) as error:
        raise RapidFault("ERR_FILEACC", f"{name}: {getattr(error, 'strerror', None) or error}") from error


def _open_file(device: FileDevice) -> BinaryIO:
    if device.file is None:
        raise RapidFault("ERR_FILEACC", "the file is closed; Open it first")
    return device.file


def _written(device: FileDevice, data: bytes) -> None:
    file = _open_file(device)
    if not file.writable():
        raise RapidFault("ERR_FILEACC", "the file is open for reading alone")
    _done(lambda: file.write(data), "the file")


def _read(device: FileDevice, count: int) -> bytes:
    file = _open_file(device)
    if not file.readable():
        raise RapidFault("ERR_FILEACC", "the file is open for writing alone")
    return _done(lambda: file.read(count), "the file")


@instruction(
    "Open", r"string Object \string File, var iodev IODevice \switch Read | switch Write | switch Append \switch Bin"
)
def _open(
    task: RapidTask,
    name: str,
    file: str | None,
    holder: list[FileDevice],
    index: int,
    read: bool | None,
    write: bool | None,
    append: bool | None,
    binary: bool | None,
) -> None:
    """Opens a file: to read, to write anew, to append, or without these for both, from its begin."""
    task.settle()
    if holder[index].file is not None:
        raise RapidFault("ERR_FILEOPEN", f"{name!r} is open already; Close it first")
    whole = name if file is None else f"{name.rstrip('/')}/{file}"
    place = _place(task, whole)
    if not read and not write and not append and not place.exists():
        mode = "w+b"
    else:
        mode = "rb" if read else "wb" if write else "ab" if append else "r+b"
    try:
        # A program keeps it open from one instruction to the next.
        holder[index].file = _done(lambda: place.open(mode), whole)  # pyright: ignore[reportAttributeAccessIssue]
    except RapidFault as fault:
        raise RapidFault("ERR_FILEOPEN", str(fault).partition(": ")[2]) from fault
    holder[index].binary = bool(binary)
    task.open_files.add(holder[index])


@instruction("Close", "var iodev IODevice")
def _close(task: RapidTask, holder: list[FileDevice], index: int) -> None:
    """Closes a file; one that is closed stays so."""
    holder[index].close()
    task.open_files.discard(holder[index])


@instruction("Rewind", "var iodev IODevice")
def _rewind(task: object, holder: list[FileDevice], index: int) -> None:
    """Goes back to the begin of a file."""
    _open_file(holder[index]).seek(0)


@instruction("ClearIOBuff", "var iodev IODevice")
def _clear_io_buff(task: object, holder: list[FileDevice], index: int) -> None:
    """Forgets what a device has received; a file has nothing of the kind."""
    _open_file(holder[index])


@instruction(
    "Write",
    r"var iodev IODevice, string String \num Num | bool Bool | pos Pos | orient Orient | dnum Dnum \switch NoNewLine",
)
def _write(task: RapidTask, holder: list[FileDevice], index: int, text: str, *more: Any) -> None:  # noqa: ANN401
    """Writes a line, with a value behind it, or without its end."""
    *values, no_new_line = more
    line = text + "".join(value_text(one) for one in values if one is not None) + ("" if no_new_line else "\n")
    _written(holder[index], line.encode("latin-1", "replace"))


@instruction("WriteStrBin", "var iodev IODevice, string Str")
def _write_str_bin(task: object, holder: list[FileDevice], index: int, text: str) -> None:
    """Writes the characters of a string."""
    _written(holder[index], text.encode("latin-1", "replace"))


@instruction("WriteBin", "var iodev IODevice, num Buffer{*}, num NChar")
def _write_bin(task: object, holder: list[FileDevice], index: int, data: list[float], count: float) -> None:
    """Writes so many numbers of an array, each as a byte."""
    if not 0 <= int(count) <= len(data):
        raise RapidFault("ERR_ARGVALERR", f"NChar is 0 to {len(data)}, not {count:g}")
    try:
        _written(holder[index], bytes(int(one) for one in data[: int(count)]))
    except ValueError as error:
        raise RapidFault("ERR_ARGVALERR", "a byte is 0 to 255") from error


@instruction("WriteRawBytes", r"var iodev IODevice, rawbytes RawData \num NoOfBytes")
def _write_raw_bytes(task: object, holder: list[FileDevice], index: int, data: bytes, count: float | None) -> None:
    """Writes raw bytes, all or so many."""
    _written(holder[index], data if count is None else data[: int(count)])


@instruction("ReadRawBytes", r"var iodev IODevice, inout rawbytes RawData \num NoOfBytes \num Time")
def _read_raw_bytes(
    task: object,
    holder: list[FileDevice],
    index: int,
    data: list[bytes],
    at: int,
    count: float | None,
    time: float | None,
) -> None:
    """Reads raw bytes, 1024 or so many; ERR_RANYBIN_EOF where there are none."""
    got = _read(holder[index], 1024 if count is None else int(count))
    if not got:
        raise RapidFault("ERR_RANYBIN_EOF", "the file is at its end")
    data[at] = got


@function("ReadStr", r"var iodev IODevice \string Delim \switch RemoveCR \switch DiscardHeaders \num Time", "string")
def _read_str(
    task: object,
    holder: list[FileDevice],
    index: int,
    delimiters: str | None,
    no_returns: bool | None,
    no_empty: bool | None,
    time: float | None,
) -> str:
    """Next line, 80 characters of it at most, or what comes before one of Delim; EOF at the end."""
    ends = (delimiters or "").encode("latin-1", "replace") + b"\n"
    while True:
        data, ended = b"", False
        while len(data) < LONGEST_TEXT:
            one = _read(holder[index], 1)
            ended = one == b""
            if ended or one in ends:
                break
            data += one
        if no_returns:
            data = data.replace(b"\r", b"")
        if data or (not no_empty and not ended):
            return data.decode("latin-1")
        if ended:
            return _EOF


@function("ReadNum", r"var iodev IODevice \string Delim \num Time", "num")
def _read_num(task: object, holder: list[FileDevice], index: int, delimiters: str | None, time: float | None) -> float:
    """Number that the next line says, or what comes before one of Delim; EOF_NUM at the end."""
    text = _read_str(task, holder, index, delimiters, True, True, time)
    if text == _EOF:
        return _EOF_NUM
    found = _NUMBER.match(text.encode("latin-1"))
    if found is None:
        raise RapidFault("ERR_RCVDATA", f"{text!r} is no number")
    return float(found[1])


@function("ReadBin", r"var iodev IODevice \num Time", "num")
def _read_bin(task: object, holder: list[FileDevice], index: int, time: float | None) -> float:
    """Next byte; EOF_BIN at the end."""
    data = _read(holder[index], 1)
    return float(data[0]) if data else _EOF_BIN


@function("ReadStrBin", r"var iodev IODevice, num NoOfChars \num Time", "string")
def _read_str_bin(task: object, holder: list[FileDevice], index: int, count: float, time: float | None) -> str:
    """Next characters, 80 at most; EOF at the end."""
    data = _read(holder[index], max(0, int(count)))
    return joined(data.decode("latin-1"), "") if data or count < 1 else _EOF


# Folders.


@function("IsFile", r"string Path \switch Directory | switch RegFile", "bool", lacking="Fifo BlockSpec CharSpec")
def _is_file(task: RapidTask, name: str, directory: bool | None, regular: bool | None) -> bool:
    """TRUE where there is a file or folder of a name, or one of the kind that is asked for."""
    task.settle()
    place = _place(task, name)
    return place.is_dir() if directory else place.is_file() if regular else place.exists()


@function("FileSize", "string Path", "num")
def _file_size(task: RapidTask, name: str) -> float:
    """Size of a file in bytes."""
    task.settle()
    return float(_done(_place(task, name).stat, name).st_size)


@function("FileTime", r"string Path \switch ModifyTime | switch AccessTime | switch StatCTime", "num")
def _file_time(task: RapidTask, name: str, modified: bool | None, accessed: bool | None, changed: bool | None) -> float:
    """Time of a file in seconds since 1970: when it was written, read, or changed its state."""
    task.settle()
    found = _done(_place(task, name).stat, name)
    return float(int(found.st_atime if accessed else found.st_ctime if changed else found.st_mtime))


@instruction("MakeDir", "string Path")
def _make_dir(task: RapidTask, name: str) -> None:
    """Makes a folder."""
    task.settle()
    _done(_place(task, name).mkdir, name)


@instruction("RemoveDir", "string Path")
def _remove_dir(task: RapidTask, name: str) -> None:
    """Removes an empty folder."""
    task.settle()
    _done(_place(task, name).rmdir, name)


@instruction("RemoveFile", "string Path")
def _remove_file(task: RapidTask, name: str) -> None:
    """Removes a file."""
    task.settle()
    _done(_place(task, name).unlink, name)


def _free(place: Path, name: str) -> Path:
    if place.exists():
        raise RapidFault("ERR_FILEEXIST", f"{name!r} is there already")
    return place


@instruction("RenameFile", "string OldPath, string NewPath")
def _rename_file(task: RapidTask, old: str, new: str) -> None:
    """Gives a file another name, which is free."""
    task.settle()
    place, other = _place(task, old), _free(_place(task, new), new)
    _done(lambda: place.rename(other), old)


@instruction("CopyFile", "string OldPath, string NewPath")
def _copy_file(task: RapidTask, old: str, new: str) -> None:
    """Copies a file to a name that is free."""
    task.settle()
    place, other = _place(task, old), _free(_place(task, new), new)
    _done(lambda: shutil.copyfile(place, other), old)


@instruction("OpenDir", "var dir Dev, string Path")
def _open_dir(task: RapidTask, holder: list[FolderDevice], index: int, name: str) -> None:
    """Opens a folder, whose names ReadDir gives."""
    task.settle()
    place = _place(task, name)
    holder[index].names = [".", "..", *_done(lambda: sorted(one.name for one in place.iterdir()), name)]


@function("ReadDir", "var dir Dev, inout string FileName", "bool")
def _read_dir(task: object, holder: list[FolderDevice], index: int, name: list[str], at: int) -> bool:
    """Gives a variable the next name in a folder, from "." and ".." on; FALSE where there is none."""
    names = holder[index].names
    if names is None:
        raise RapidFault("ERR_FILEACC", "the folder is closed; OpenDir it first")
    if not names:
        return False
    name[at] = joined(names.pop(0), "")
    return True


@instruction("CloseDir", "var dir Dev")
def _close_dir(task: object, holder: list[FolderDevice], index: int) -> None:
    """Closes a folder."""
    holder[index].names = None
