MODULE motion_program_exec
    ! Runs the programs that the Python package abb-motion-program-exec (0.7) uploads, on the emulated controller.
    ! A file is a row of 32-bit floats: a head, and commands of a number, a code, and what the code needs.

    CONST num FORMAT := 10011;
    CONST num SAMPLE_SECONDS := 0.02;

    TASK PERS tooldata motion_program_tool := [TRUE, [[0,0,0],[1,0,0,0]], [0.001,[0,0,0.001],[1,0,0,0],0,0,0]];
    TASK PERS wobjdata motion_program_wobj := [FALSE, TRUE, "", [[0,0,0],[1,0,0,0]], [[0,0,0],[1,0,0,0]]];
    TASK PERS loaddata motion_program_load := [0.001, [0,0,0.001], [1,0,0,0], 0, 0, 0];

    LOCAL VAR iodev program_file;
    LOCAL VAR rawbytes read;
    LOCAL VAR num place := 1;
    LOCAL VAR num command := 0;
    LOCAL VAR string stamp;

    LOCAL VAR intnum timer;
    LOCAL VAR clock since;
    LOCAL VAR iodev log_file;
    LOCAL VAR bool logs := FALSE;
    LOCAL VAR num preempt := 0;
    LOCAL VAR num preempt_asked := 0;
    LOCAL VAR num preempt_after := 0;

    LOCAL VAR num egm_kind := 0;
    LOCAL VAR pose egm_frames{2};
    LOCAL VAR num egm_types{2};
    LOCAL VAR egm_minmax egm_ranges{6};
    LOCAL VAR num egm_farthest;
    LOCAL VAR num egm_fastest;
    LOCAL VAR egmident egm_guide;
    LOCAL VAR intnum egm_stopped;

    PROC main()
        SetAO motion_program_preempt, 0;
        SetAO motion_program_preempt_current, 0;
        preempt := 0;
        open_program;
        open_log;
        IDelete timer;
        CONNECT timer WITH sample;
        ITimer \Single, SAMPLE_SECONDS, timer;
        WHILE more() DO
            command := next();
            SetAO motion_program_current_cmd_num, command;
            do_command next();
            IF preempt_asked > preempt AND command = preempt_after THEN
                preempt := preempt_asked;
                SetAO motion_program_preempt_current, preempt;
                Close program_file;
                open_program;
            ENDIF
        ENDWHILE
        WaitTime \InPos, 0;
        IDelete timer;
        Close program_file;
        close_log;
    ERROR
        ErrWrite "Motion Program Failed", "in command " + NumToStr(command, 0), \RL2:="error " + NumToStr(ERRNO, 0),
            \RL3:="program of " + stamp, \RL4:="the log tells more";
        RAISE;
    ENDPROC

    LOCAL PROC failed(string why)
        ErrWrite "Motion Program Failed", "in command " + NumToStr(command, 0), \RL2:=why, \RL3:="program of " + stamp,
            \RL4:="nothing more is done";
        EXIT;
    ENDPROC

    ! Reading.

    LOCAL PROC open_program()
        VAR string name := "motion_program";
        VAR string index;
        VAR num version;
        index := StrPart(GetTaskName(), 6, StrLen(GetTaskName()) - 5);
        IF index <> "1" name := name + index;
        IF preempt > 0 name := name + "_p" + NumToStr(preempt, 0);
        Open "RAMDISK:", \File:=name + ".bin", program_file \Read \Bin;
        ClearRawBytes read;
        place := 1;
        version := next();
        IF version <> FORMAT failed "its format is " + NumToStr(version, 0) + " and not " + NumToStr(FORMAT, 0);
        motion_program_tool.robhold := next() <> 0;
        motion_program_tool.tframe := next_pose();
        motion_program_tool.tload := next_load();
        motion_program_wobj.robhold := next() <> 0;
        motion_program_wobj.ufprog := next() <> 0;
        motion_program_wobj.ufmec := next_text();
        motion_program_wobj.uframe := next_pose();
        motion_program_wobj.oframe := next_pose();
        motion_program_load := next_load();
        stamp := next_text();
        SetAO motion_program_seqno, next();
        read_egm next();
    ENDPROC

    LOCAL PROC read_egm(num kind)
        egm_kind := kind;
        TEST kind
        CASE 0:
            RETURN;
        CASE 1:
            read_ranges;
        CASE 2:
            FOR i FROM 1 TO 2 DO
                egm_frames{i} := next_pose();
                egm_types{i} := next();
            ENDFOR
            read_ranges;
        CASE 3:
            egm_frames{1} := next_pose();
        DEFAULT:
            failed "there is no EGM configuration " + NumToStr(kind, 0);
        ENDTEST
    ENDPROC

    LOCAL PROC read_ranges()
        FOR i FROM 1 TO 6 DO
            egm_ranges{i} := [next(), next()];
        ENDFOR
        egm_farthest := next();
        egm_fastest := next();
    ENDPROC

    LOCAL FUNC bool more()
        IF place + 3 <= RawBytesLen(read) RETURN TRUE;
        ClearRawBytes read;
        ReadRawBytes program_file, read;
        place := 1;
        RETURN TRUE;
    ERROR
        IF ERRNO = ERR_RANYBIN_EOF RETURN FALSE;
    ENDFUNC

    LOCAL FUNC num next()
        VAR num value;
        IF NOT more() failed "its file ends within a command";
        UnpackRawBytes read, place, value \Float4;
        place := place + 4;
        RETURN value;
    ENDFUNC

    LOCAL FUNC string next_text()
        VAR string text;
        VAR num length;
        length := next();
        UnpackRawBytes read, place, text \ASCII:=32;
        place := place + 32;
        RETURN StrPart(text, 1, length);
    ERROR
        IF length = 0 RETURN "";
    ENDFUNC

    LOCAL FUNC pos next_pos()
        RETURN [next(), next(), next()];
    ENDFUNC

    LOCAL FUNC orient next_orient()
        RETURN [next(), next(), next(), next()];
    ENDFUNC

    LOCAL FUNC pose next_pose()
        RETURN [next_pos(), next_orient()];
    ENDFUNC

    LOCAL FUNC loaddata next_load()
        RETURN [next(), next_pos(), next_orient(), next(), next(), next()];
    ENDFUNC

    LOCAL FUNC extjoint next_external()
        RETURN [next(), next(), next(), next(), next(), next()];
    ENDFUNC

    LOCAL FUNC robtarget next_target()
        RETURN [next_pos(), next_orient(), [next(), next(), next(), next()], next_external()];
    ENDFUNC

    LOCAL FUNC jointtarget next_joints()
        RETURN [[next(), next(), next(), next(), next(), next()], next_external()];
    ENDFUNC

    LOCAL FUNC speeddata next_speed()
        RETURN [next(), next(), next(), next()];
    ENDFUNC

    LOCAL FUNC zonedata next_zone()
        RETURN [next() <> 0, next(), next(), next(), next(), next(), next()];
    ENDFUNC

    ! Moving.

    LOCAL PROC do_command(num code)
        VAR jointtarget joints;
        VAR robtarget via;
        VAR robtarget target;
        VAR speeddata speed;
        VAR zonedata zone;
        TEST code
        CASE 1:
            joints := next_joints();
            speed := next_speed();
            zone := next_zone();
            MoveAbsJ joints, speed, zone, motion_program_tool \WObj:=motion_program_wobj;
        CASE 2, 3:
            target := next_target();
            speed := next_speed();
            zone := next_zone();
            IF code = 2 THEN
                MoveJ target, speed, zone, motion_program_tool \WObj:=motion_program_wobj;
            ELSE
                MoveL target, speed, zone, motion_program_tool \WObj:=motion_program_wobj;
            ENDIF
        CASE 4:
            via := next_target();
            target := next_target();
            speed := next_speed();
            zone := next_zone();
            MoveC via, target, speed, zone, motion_program_tool \WObj:=motion_program_wobj;
        CASE 5:
            WaitTime next();
        CASE 6:
            failed "CirPathMode does not work here yet";
        CASE 7, 8:
            failed "SyncMoveOn and SyncMoveOff do not work here yet";
        CASE 50001, 50002:
            run_egm code;
        CASE 50003, 50004:
            failed "path correction by EGM does not work here yet";
        DEFAULT:
            failed "there is no command code " + NumToStr(code, 0);
        ENDTEST
    ENDPROC

    LOCAL PROC run_egm(num code)
        VAR num condition;
        VAR num ramp_in;
        VAR num ramp_out;
        VAR pose offset := [[0,0,0],[1,0,0,0]];
        VAR string device := "UCdevice";
        condition := next();
        ramp_in := next();
        ramp_out := next();
        IF code = 50002 offset := next_pose();
        IF offset <> [[0,0,0],[1,0,0,0]] failed "an offset of EGMRunPose does not work here yet";
        IF egm_kind <> code - 50000 failed "the program has no EGM configuration for this command";
        IF GetTaskName() <> "T_ROB1" device := device + StrPart(GetTaskName(), 6, StrLen(GetTaskName()) - 5);
        SetDO motion_program_stop_egm, 0;
        IDelete egm_stopped;
        CONNECT egm_stopped WITH stop_egm;
        ISignalDO motion_program_stop_egm, 1, egm_stopped;
        EGMReset egm_guide;
        EGMGetId egm_guide;
        IF code = 50001 THEN
            EGMSetupUC ROB_1, egm_guide, "joint", device \Joint;
            EGMActJoint egm_guide \Tool:=motion_program_tool \WObj:=motion_program_wobj \J1:=egm_ranges{1}
                \J2:=egm_ranges{2} \J3:=egm_ranges{3} \J4:=egm_ranges{4} \J5:=egm_ranges{5} \J6:=egm_ranges{6}
                \MaxPosDeviation:=egm_farthest \MaxSpeedDeviation:=egm_fastest;
            EGMRunJoint egm_guide, EGM_STOP_HOLD \J1 \J2 \J3 \J4 \J5 \J6 \CondTime:=condition
                \RampInTime:=ramp_in \RampOutTime:=ramp_out;
        ELSE
            EGMSetupUC ROB_1, egm_guide, "pose", device \Pose;
            EGMActPose egm_guide \Tool:=motion_program_tool \WObj:=motion_program_wobj, egm_frames{1}, egm_types{1},
                egm_frames{2}, egm_types{2} \X:=egm_ranges{1} \Y:=egm_ranges{2} \Z:=egm_ranges{3}
                \Rx:=egm_ranges{4} \Ry:=egm_ranges{5} \Rz:=egm_ranges{6} \MaxPosDeviation:=egm_farthest
                \MaxSpeedDeviation:=egm_fastest;
            EGMRunPose egm_guide, EGM_STOP_HOLD \X \Y \Z \Rx \Ry \Rz \CondTime:=condition
                \RampInTime:=ramp_in \RampOutTime:=ramp_out;
        ENDIF
        IDelete egm_stopped;
        EGMReset egm_guide;
    ENDPROC

    LOCAL TRAP stop_egm
        EGMStop egm_guide, EGM_STOP_HOLD;
    ENDTRAP

    ! The log of the way: time, number of the command, joints.

    LOCAL FUNC string log_name()
        RETURN "log-" + stamp + ".bin";
    ENDFUNC

    LOCAL PROC open_log()
        Open "RAMDISK:", \File:=log_name(), log_file \Write \Bin;
        ErrWrite \I, "Motion Program log file opened", log_name();
        write_number FORMAT;
        write_text stamp;
        write_text "timestamp,cmdnum,J1,J2,J3,J4,J5,J6";
        ClkReset since;
        ClkStart since;
        logs := TRUE;
    ENDPROC

    LOCAL PROC close_log()
        IF DOutput(motion_program_log_motion) = 1 sample_now;
        logs := FALSE;
        Close log_file;
        ErrWrite \I, "Motion Program log file closed", log_name();
    ENDPROC

    LOCAL TRAP sample
        IF logs AND DOutput(motion_program_log_motion) = 1 sample_now;
        preempt_asked := AOutput(motion_program_preempt);
        preempt_after := AOutput(motion_program_preempt_cmd_num);
        SetAO motion_program_queued_cmd_num, command;
        ITimer \Single, SAMPLE_SECONDS, timer;
    ENDTRAP

    LOCAL PROC sample_now()
        VAR rawbytes row;
        VAR jointtarget now;
        now := CJointT();
        pack row, ClkRead(since);
        pack row, AOutput(motion_program_current_cmd_num);
        pack row, now.robax.rax_1;
        pack row, now.robax.rax_2;
        pack row, now.robax.rax_3;
        pack row, now.robax.rax_4;
        pack row, now.robax.rax_5;
        pack row, now.robax.rax_6;
        WriteRawBytes log_file, row;
    ENDPROC

    LOCAL PROC pack(VAR rawbytes row, num value)
        PackRawBytes value, row, RawBytesLen(row) + 1 \Float4;
    ENDPROC

    LOCAL PROC write_number(num value)
        VAR rawbytes row;
        pack row, value;
        WriteRawBytes log_file, row;
    ENDPROC

    LOCAL PROC write_text(string text)
        VAR rawbytes row;
        pack row, StrLen(text);
        PackRawBytes text, row, 5 \ASCII;
        WriteRawBytes log_file, row;
    ENDPROC
ENDMODULE
