"""Table of RAPID's instructions and functions: a row for each that works, and the names of those that don't yet.

A row is the function that does it, with its parameters in RAPID's own words. Check, documentation and tests read it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.parser import Parser

Run = TypeVar("Run", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Builtin:
    """An instruction or function that comes with the language.

    Attributes:
        name: as the manual writes it.
        signature: its parameters as a routine would declare them.
        parameters: the same, parsed.
        result: the type of a function's value; empty of an instruction.
        text: the sentence that tells people what it does.
        room: the module that has it.
        run: the function that does it, called with the task and each argument: a value, None where it is left out, and
            for a variable the list that holds it and the index there.
        lacking: arguments that the manual has, and that are refused by name, in small letters.
        lazy: parameters that are given as a function, which computes the argument anew each time, in small letters.
    """

    name: str
    signature: str
    parameters: list[tree.Parameter]
    result: str
    text: str
    room: str
    run: Callable[..., Any]
    lacking: frozenset[str]
    lazy: frozenset[str]


BUILTINS: dict[str, Builtin] = {}
"""All that works, by name in small letters."""


def instruction(name: str, signature: str = "", *, lacking: str = "", lazy: str = "") -> Callable[[Run], Run]:
    """Enter a function as an instruction; the first line of its docstring tells what it does."""
    return _entered(name, signature, "", lacking, lazy)


def function(name: str, signature: str, result: str, *, lacking: str = "") -> Callable[[Run], Run]:
    """Enter a function as one of the language, with the type of its value."""
    return _entered(name, signature, result, lacking)


def _entered(name: str, signature: str, result: str, lacking: str, lazy: str = "") -> Callable[[Run], Run]:
    def enter(run: Run) -> Run:
        diagnostics = Diagnostics()
        parameters = Parser(Source(signature, name), diagnostics).parameters("end")
        if len(diagnostics):
            raise ProgramError(diagnostics.sorted())
        text = (run.__doc__ or "").partition("\n")[0]
        room = run.__module__.rpartition(".")[2]
        left_out, later = frozenset(lacking.lower().split()), frozenset(lazy.lower().split())
        BUILTINS[name.lower()] = Builtin(name, signature, parameters, result, text, room, run, left_out, later)
        return run

    return enter


_LACKING = """
AccSet ActEventBuffer ActUnit AInput AliasIO AOutput BitAnd BitCheck BitClear BitLSh BitNeg BitOr BitRSh BitSet BitXOr
BookErrNo Break ByteToStr CalcJointT CalcRobT CalcRotAxFrameZ CallByVar CancelLoad CDate CheckProgRef CirPathMode
CJointT ClearIOBuff ClearPath ClearRawBytes Close CloseDir ConfJ ConfL CopyFile CopyRawBytes CorrClear CorrCon
CorrDiscon CorrRead CorrWrite CPos CRobT CSpeedOverride CTime CTool CWObj DeactUnit DecToHex DefAccFrame DefDFrame
DefFrame DInput DitherAct DitherDeact DnumToNum DnumToStr DOutput DropWObj EGMActJoint EGMActMove EGMActPose EGMGetId
EGMGetState EGMMoveC EGMMoveL EGMReset EGMRunJoint EGMRunPose EGMSetupAI EGMSetupAO EGMSetupGI EGMSetupUC EGMStop
EGMStreamStart EGMStreamStop EGMWaitCond EOffsOff EOffsOn EOffsSet
EraseModule ErrLog ErrRaise EventType ExecHandler ExecLevel ExitCycle FileSize FileTime FSSize GetAxisPosition
GetDataVal GetJointData GetNextSym GetSysData GetSysInfo GetTaskName GetTime GetTrapData GInput GOutput GripLoad
HollowWristReset IDelete IDisable IEnable IError IndAMove IndCMove IndDMove IndReset IndRMove InvertDO IPers
IRMQMessage IsFile ISignalAI ISignalAO ISignalDI ISignalDO ISignalGI ISignalGO ISleep IsMechUnitActive IsPers
IsStopMoveAct IsStopStateEvent IsSyncMoveOn IsVar ITimer IVarValue IWatch Load LoadId MakeDir MechUnitLoad ModExist
ModTime MotionSup MoveAbsJ MoveC MoveCAO MoveCDO MoveCGO MoveCSync MoveExtJ MoveJ MoveJAO MoveJDO MoveJGO MoveJSync
MoveL MoveLAO MoveLDO MoveLGO MoveLSync MToolRotCalib MToolTCPCalib NumToDnum Open OpenDir OpMode ORobT PackDNHeader
PackRawBytes ParIdPosValid ParIdRobValid PathLevel PathRecMoveBwd PathRecMoveFwd PathRecStart PathRecStop
PathResol PDispOff PDispOn PDispSet PFL PFRestart ProcCall ProcerrRecovery ProgMemFree PrxActivRec PulseDO RaiseToUser
RawBytesLen ReadAnyBin ReadBin ReadBlock ReadCfgData ReadDir ReadErrData ReadMotor ReadNum ReadRawBytes ReadStr
ReadStrBin ReadVar ReadVarArr ReadWaitTime RelRob RemainingRetries RemoveAllCyclicBool RemoveDir RemoveFile RenameFile
Reset ResetPPMoved ResetRetryCount RestoPath Rewind RMQFindSlot RMQGetMessage RMQSendMessage RobName RobOS RunMode Save
SaveCfgData SCWrite SearchC SearchExtJ SearchL SenDevice Set SetAllDataVal SetAO SetDataSearch SetDataVal SetDO SetGO
SetSysData SetupCyclicBool SiConnect SiGetCyclic SimLoad SingArea SkipWarn SocketAccept SocketBind SocketClose
SocketConnect SocketCreate SocketGetStatus SocketListen SocketPeek SocketReceive SocketReceiveFrom SocketSend
SocketSendTo SoftAct SoftDeact SpeedLimAxis SpeedLimCheckPoint SpeedRefresh SpyStart SpyStop StartLoad StartMove
StartMoveRetry STCalcForce STClose Stop STOpen StopMove StopMoveReset StorePath StrDigCalc StrDigCmp StrFormat
StrOrder StrToByte SyncMoveOff SyncMoveOn SyncMoveResume SyncMoveSuspend SyncMoveUndo SysStopAct SystemStopAct
TaskRunMec TaskRunRob TasksInSync TestAndSet TestDI TestSignDefine TestSignRead TestSignReset TextGet TextTabFreeToUse
TextTabGet TextTabInstall TPErase TPReadDnum TPReadFK TPReadNum TPShow TriggAbsJ TriggC TriggCheckIO TriggDataCopy
TriggDataReset TriggDataValid TriggEquip TriggInt TriggIO TriggJ TriggJIOs TriggL TriggLIOs TriggRampAO TriggSpeed
TriggStopProc TryInt TuneReset TuneServo UIAlphaEntry UIClientExist UIDnumEntry UIDnumTune UIListView UIMessageBox
UIMsgBox UINumEntry UINumTune UIShow UnLoad UnpackRawBytes UserOverride VelSet WaitAI WaitAO WaitDI WaitDO WaitGI
WaitGO WaitLoad WaitRob WaitSensor WaitSyncTask WaitTestAndSet WaitTime WaitUntil WaitWObj WarmStart World Write
WriteAnyBin WriteBin WriteBlock WriteCfgData WriteRawBytes WriteStrBin WriteVar WriteVarArr WZBoxDef WZCylDef
WZDisable WZDOSet WZEnable WZFree WZHomeJointDef WZLimJointDef WZLimSup WZSphDef
"""


def lacking_names() -> dict[str, str]:
    """Return the instructions and functions of the manual that are refused by name, by name in small letters."""
    return {name.lower(): name for name in sorted(_LACKING.split()) if name.lower() not in BUILTINS}
