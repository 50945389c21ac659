"""Files, raw bytes and questions of programs in RAPID, by what they print and leave behind; no kernel is needed."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

import pytest
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS
from virtualrobot_apps.languages.rapid.task import RapidTask

from tests.apps.languages.rapid import fault_of, faults, loaded, main_prints


def with_files(folder: Path, statements: str, more: str = "", answers: Iterable[str] = ()) -> list[str]:
    """Return what statements of main print that may use a folder and get answers."""
    lines: list[str] = []
    program = loaded(f"MODULE Tried\n{more}\nPROC main()\n{statements}\nENDPROC\nENDMODULE")
    RapidTask(program, None, lines.append, files=folder, answers=answers).run()
    return lines


def test_lines_and_bytes_go_to_a_file_and_come_back(tmp_path: Path) -> None:
    assert with_files(
        tmp_path,
        r"""
        VAR iodev log;
        VAR num bytes{3} := [65, 66, 67];
        VAR rawbytes raw;
        Open "HOME:" \File:="day.txt", log \Write;
        Write log, "x is " \Num:=1.5;
        Write log, "at " \Pos:=[1, 2, 3];
        Write log, "12.5;" \NoNewLine;
        WriteStrBin log, "-7\0D\0A";
        WriteBin log, bytes, 2;
        Close log;
        Open "HOME:/day.txt", log \Append \Bin;
        PackRawBytes 258, raw \Network, 1 \IntX:=UINT;
        WriteRawBytes log, raw;
        Close log;
        Open "/hd0a/../day.txt", log \Read;
        TPWrite ReadStr(log);
        TPWrite ReadStr(log \Delim:=" ") + "|" + ReadStr(log);
        TPWrite "" \Num:=ReadNum(log \Delim:=";");
        TPWrite "" \Num:=ReadNum(log);
        TPWrite ReadStrBin(log, 1) \Num:=ReadBin(log);
        ReadRawBytes log, raw;
        TPWrite "" \Num:=RawBytesLen(raw);
        TPWrite ReadStr(log) \Bool:=ReadBin(log) = EOF_BIN AND ReadNum(log) = EOF_NUM AND ReadStr(log) = EOF;
        Rewind log;
        TPWrite ReadStr(log);
        Close log;
        Close log;
        Open "day.txt", log;
        WriteStrBin log, "X";
        ClearIOBuff log;
        Close log;
        """,
    ) == ["x is 1.5", "at|[1,2,3]", "12.5", "-7", "A66", "2", "EOFTRUE", "x is 1.5"]
    assert (tmp_path / "day.txt").read_bytes() == b"X is 1.5\nat [1,2,3]\n12.5;-7\r\nAB\x01\x02"


def test_folders_are_made_read_and_removed(tmp_path: Path) -> None:
    lines = with_files(
        tmp_path,
        r"""
        VAR iodev file;
        VAR dir folder;
        VAR string name;
        MakeDir "HOME:/logs";
        Open "HOME:/logs/a.txt", file \Write;
        Write file, "four" \NoNewLine;
        Close file;
        CopyFile "logs/a.txt", "logs/b.txt";
        RenameFile "logs/b.txt", "logs/c.txt";
        OpenDir folder, "HOME:/logs";
        WHILE ReadDir(folder, name) DO TPWrite name; ENDWHILE
        CloseDir folder;
        TPWrite "" \Num:=FileSize("logs/c.txt");
        TPWrite "" \Bool:=IsFile("logs" \Directory) AND NOT IsFile("logs" \RegFile) OR IsFile("none");
        TPWrite "" \Bool:=FileTime("logs/a.txt" \ModifyTime) > 1.7E9;
        RemoveFile "logs/a.txt";
        RemoveFile "logs/c.txt";
        RemoveDir "logs";
        TPWrite "" \Bool:=IsFile("logs");
        """,
    )
    assert lines == [".", "..", "a.txt", "c.txt", "4", "TRUE", "TRUE", "FALSE"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ('Open "../out.txt", file \\Write;', "ERR_FILEACC: '../out.txt' leads out of "),
        ('Open "none.txt", file \\Read;', "ERR_FILEOPEN: there is no 'none.txt'"),
        ('Write file, "x";', "ERR_FILEACC: the file is closed; Open it first"),
        ('Open "a", file \\Write; Open "b", file \\Write;', "ERR_FILEOPEN: 'b' is open already; Close it first"),
        ('Open "a", file \\Write; reg1 := ReadBin(file);', "ERR_FILEACC: the file is open for writing alone"),
        ('Open "here", file \\Read; Write file, "x";', "ERR_FILEACC: the file is open for reading alone"),
        ('Open "here", file \\Read; reg1 := ReadNum(file);', "ERR_RCVDATA: 'some words' is no number"),
        ('RemoveFile "none.txt";', "ERR_FILNOTFND: there is no 'none.txt'"),
        ('MakeDir "here";', "ERR_FILEEXIST: 'here' is there already"),
        ('CopyFile "here", "here";', "ERR_FILEEXIST: 'here' is there already"),
        ("reg1 := ReadStrLen();", ""),
    ],
)
def test_what_can_not_be_done_with_files_is_an_error_of_the_program(tmp_path: Path, statement: str, error: str) -> None:
    (tmp_path / "here").write_text("some words\n")
    if not error:
        assert fault_of(statement).startswith("there is no function 'ReadStrLen'")
        return
    with pytest.raises(RapidStopped) as caught:
        with_files(tmp_path, statement, "VAR iodev file;")
    assert f": {error}" in str(caught.value)
    assert not (tmp_path.parent / "out.txt").exists()


def test_files_need_leave() -> None:
    with pytest.raises(RapidStopped, match="wants the file 'HOME:/a': allow it a folder by --files FOLDER"):
        main_prints('Open "HOME:/a", file \\Write;', "VAR iodev file;")


def test_a_link_does_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link").symlink_to(tmp_path)
    with pytest.raises(RapidStopped, match="ERR_FILEACC: 'link/x' leads out of "):
        with_files(tmp_path / "in", 'Open "link/x", file \\Write;', "VAR iodev file;")


def test_raw_bytes_are_those_of_struct(tmp_path: Path) -> None:
    """The bytes are compared with Python's struct, those of the network being big-endian."""
    with_files(
        tmp_path,
        r"""
        VAR iodev file;
        VAR rawbytes a;
        VAR rawbytes b;
        PackRawBytes 1.5, a, 1 \Float4;
        PackRawBytes -2, a \Network, RawBytesLen(a) + 1 \IntX:=DINT;
        PackRawBytes 255, a, 9 \Hex1;
        PackRawBytes "end", a, 12 \ASCII;
        CopyRawBytes a, 1, b, 2 \NoOfBytes:=4;
        Open "bytes", file \Write \Bin;
        WriteRawBytes file, a;
        WriteRawBytes file, b \NoOfBytes:=5;
        Close file;
        ClearRawBytes a \FromIndex:=3;
        ClearRawBytes b;
        TPWrite "" \Num:=RawBytesLen(a) + RawBytesLen(b);
        """,
    )
    expected = struct.pack("<f", 1.5) + struct.pack(">i", -2) + b"\xff\0\0end" + b"\0" + struct.pack("<f", 1.5)
    assert (tmp_path / "bytes").read_bytes() == expected


@pytest.mark.parametrize("name", ["DINT", "INT", "LINT", "SINT", "UDINT", "UINT", "ULINT", "USINT"])
def test_what_is_packed_is_unpacked(name: str) -> None:
    value = 7 if name.startswith("U") else -7
    size = {"S": 1, "I": 2, "D": 4, "L": 8}[name.removeprefix("U")[0]]
    assert CONSTANTS[name][1] == (size if name.startswith("U") else -size)
    assert main_prints(
        rf"""
        VAR rawbytes raw;
        VAR num back;
        VAR string text;
        PackRawBytes {value}, raw \Network, 3 \IntX:={name};
        UnpackRawBytes raw \Network, 3, back \IntX:={name};
        PackRawBytes "ab", raw, 1 \ASCII;
        UnpackRawBytes raw, 1, text \ASCII:=2;
        TPWrite text \Num:=back;
        """
    ) == [f"ab{value}"]


@pytest.mark.parametrize(
    ("statement", "error"),
    [
        (r"PackRawBytes 300, raw, 1 \Hex1;", "300 does not go into what it is packed as"),
        (r"PackRawBytes 1.5, raw, 1 \IntX:=UINT;", "1.5 does not go into what it is packed as"),
        (r"PackRawBytes 1, raw, 1025 \Hex1;", "a place in raw bytes is 1 to 1024 here, not 1025"),
        (r"PackRawBytes 1, raw, 1024 \IntX:=UINT;", "raw bytes are 1024 at most, and these were 1025"),
        (r"PackRawBytes 1, raw, 1 \IntX:=3;", r"\IntX is one of USINT to LINT, not 3"),
        (r"PackRawBytes 1, raw, 1;", r"PackRawBytes needs \Hex1, \IntX, \Float4 or \ASCII"),
        (r"UnpackRawBytes raw, 1, reg1 \Float4;", "4 bytes from 1 on are more than the 0 that are set"),
        (r"PackRawBytes 65, raw, 1 \ASCII; UnpackRawBytes raw, 1, reg1 \ASCII:=1;", r"\ASCII is for a string"),
    ],
)
def test_raw_bytes_that_do_not_fit_are_told(statement: str, error: str) -> None:
    with pytest.raises(RapidStopped) as caught:
        main_prints(statement, "VAR rawbytes raw;")
    assert error in str(caught.value)


def test_questions_are_asked_until_their_answer_fits(tmp_path: Path) -> None:
    lines = with_files(
        tmp_path,
        r"""
        VAR num number;
        VAR btnres button;
        VAR listitem items{2} := [["", "one"], ["", "two"]];
        TPReadFK number, "which?", "left", "", "right", stEmpty, "";
        TPWrite "> " \Num:=number;
        TPReadNum number, "many?";
        TPWrite "> " \Num:=number;
        UIMsgBox \Header:="Gripper", "open it?" \MsgLine2:="now" \Buttons:=btnYesNo \Result:=button;
        TPWrite "> " \Bool:=button = resNo;
        UIMsgBox "done" \Buttons:=btnNone;
        TPWrite "> " + UIAlphaEntry(\Message:="name?" \InitString:="abc");
        TPWrite "> " \Num:=UIListView(\Header:="pick", items);
        TPWrite "> " \Num:=UIMessageBox(\Message:="go?" \BtnArray:=["yes", "later"]);
        TPWrite "> " \Num:=UINumEntry(\Message:="how?" \InitValue:=5 \MaxValue:=10 \AsInteger);
        """,
        answers=["up", "Right", "x", "4", "no", "", "2", "later", "11", "2.5", "7"],
    )
    assert [one for one in lines if one.startswith(">")] == [
        *("> 3", "> 4", "> TRUE", "> abc", "> 2", "> 2", "> 7"),
    ]
    assert lines[:3] == ["which? [1: left, 3: right]", "'up' is none of them", "which? [1: left, 3: right]"]
    assert "Gripper\nopen it?\nnow [1: Yes, 2: No]" in lines
    assert lines[-3:] == ["'2.5' is no whole number that is allowed", "how? [to 10, empty: 5]", "> 7"]


def test_a_question_without_an_answer_ends_the_program_and_one_in_time_is_an_error() -> None:
    with pytest.raises(RapidStopped, match=r"asks 'many\?', and there is no answer: give one by --answer TEXT"):
        main_prints('TPReadNum reg1, "many?";')

    def nobody() -> Iterable[str]:
        threading.Event().wait(60)
        yield ""

    lines: list[str] = []
    program = loaded(
        r"""
        MODULE Tried
        PROC main()
          TPWrite "" \Num:=UIMessageBox(\Message:="go?" \DefaultBtn:=resCancel \MaxTime:=0.01);
          TPReadNum reg1, "many?" \MaxTime:=0.01;
        ERROR
          IF ERRNO = ERR_TP_MAXTIME TPWrite "too late";
          TRYNEXT;
        ENDPROC
        ENDMODULE
        """
    )
    RapidTask(program, None, lines.append, answers=nobody()).run()
    assert lines == ["go? [1: OK]", "5", "many?", "too late"]


def test_stop_waits_for_an_answer_and_exit_cycle_ends() -> None:
    with pytest.raises(RapidStopped, match="Stop, and no answer lets the program go on"):
        main_prints("Stop;")
    lines: list[str] = []
    program = loaded(
        'MODULE T\nPROC main()\nStop;\nBreak;\nTPWrite "on";\nExitCycle;\nTPWrite "never";\nENDPROC\nENDMODULE'
    )
    RapidTask(program, None, lines.append, answers=["", ""]).run()
    assert lines == ["stopped: an answer lets the program go on"] * 2 + ["on"]


UNDONE = r"""
PROC outer()
  VAR num n := 1;
  inner;
{handler}
UNDO
  TPWrite "outer" \Num:=n;
ENDPROC
FUNC num broken()
  VAR num n := 0;
  n := n + 2;
  {last}
  RETURN n;
UNDO
  TPWrite "broken" \Num:=n;
  RAISE;
ENDFUNC
PROC inner()
  VAR num x;
  x := broken();
ENDPROC
"""


def test_undo_is_done_where_a_program_ends_in_its_routines_and_not_where_a_handler_goes_on() -> None:
    """Variables are those of the routine as it was left; the innermost part is done first."""
    failing = UNDONE.format(handler="", last="n := 1 / (n - 2);")
    program = loaded(f"MODULE Tried\n{failing}\nPROC main() outer; ENDPROC\nENDMODULE")
    lines: list[str] = []
    with pytest.raises(RapidStopped, match="ERR_DIVZERO"):
        RapidTask(program, None, lines.append).run()
    assert lines == ["broken2", "outer1"]
    assert main_prints("outer; EXIT;", UNDONE.format(handler="", last="EXIT;")) == ["broken2", "outer1"]
    handled = UNDONE.format(handler="ERROR TRYNEXT;", last="n := 1 / (n - 2);")
    assert main_prints('outer; TPWrite "on";', handled) == ["on"]
    assert main_prints('outer; TPWrite "on";', UNDONE.format(handler="", last="")) == ["on"]


def test_undo_is_done_after_a_stop_and_its_own_errors_are_told() -> None:
    more = r"""
    PROC waits()
      task_is_here := TRUE;
      WHILE TRUE DO ENDWHILE
    UNDO
      TPWrite "closed";
      reg1 := 1 / 0;
    ENDPROC
    PERS bool task_is_here := FALSE;
    """
    lines: list[str] = []
    program = loaded(f"MODULE Tried\n{more}\nPROC main() waits; ENDPROC\nENDMODULE")
    task = RapidTask(program, None, lines.append)
    threading.Timer(0.05, task.stop, ["by hand"]).start()
    with pytest.raises(TaskStopped, match="by hand"):
        task.run()
    assert lines == ["closed", "error: in UNDO: ERR_DIVZERO: a division by zero"]


def test_undo_takes_no_retry() -> None:
    assert faults("MODULE T\nPROC main()\nUNDO\nRETRY;\nENDPROC\nENDMODULE") == [
        "4:1: RETRY stands in error handlers alone"
    ]


def test_the_time_is_that_of_the_machine() -> None:
    before = datetime.now()
    date, time = main_prints("TPWrite CDate(); TPWrite CTime();", once=True)
    assert before.strftime("%Y-%m-%d %H:%M:%S") <= f"{date} {time}" <= datetime.now().strftime("%Y-%m-%d %H:%M:%S")


def test_times_names_and_texts() -> None:
    lines = main_prints(
        r"""
        VAR errnum ERR_OWN := -1;
        VAR errnum ERR_OTHER := -1;
        TPWrite "" \Bool:=GetTime(\Year) >= 2026 AND GetTime(\WDay) <= 7 AND GetTime(\Sec) <= 60;
        TPWrite DecToHex("255") + HexToDec("ff") \Bool:=StrOrder("ab", "b", STR_LOWER);
        TPWrite StrFormat("{2} of {1}" \Arg1:="a" \Arg2:="b") + StrMap("aÄz", STR_LOWER, STR_UPPER);
        TPWrite DnumToStr(NumToDnum(1.5), 1) \Num:=DnumToNum(4 \Integer);
        TPWrite "" \Bool:=StrDigCmp("12", LT, "112") AND NOT StrDigCmp("12", GT, "12");
        TPWrite "" \Bool:=OpMode() = OP_AUTO AND NOT RobOS() AND UIClientExist();
        reg1 := ClkRead(clock1 \HighRes);
        TPWrite "" \Bool:=RunMode(\Main) = RUN_CONT_CYCLE AND MaxRobSpeed() = vmax.v_tcp AND reg1 = 0;
        ErrLog 5001 \W, "one", stEmpty, "three", "", "";
        CallByVar "show", 2;
        TPShow 1;
        ResetRetryCount;
        BookErrNo ERR_OWN;
        BookErrNo ERR_OTHER;
        TPWrite "" \Bool:=TestAndSet(flag) AND NOT TestAndSet(flag) AND ERR_OWN <> ERR_OTHER;
        flag := FALSE;
        WaitTestAndSet flag;
        RAISE ERR_OWN;
        ERROR
          IF ERRNO = ERR_OWN TPWrite "own";
        TRYNEXT;
        """,
        'VAR bool flag := FALSE; PROC show2() TPWrite "two"; ENDPROC',
    )
    assert lines == [
        *("TRUE", "FF255TRUE", "b of aAÄZ", "1.54", "TRUE", "TRUE", "TRUE", "warning 5001: one; three", "two", "TRUE"),
        "own",
    ]
