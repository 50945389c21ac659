MODULE Turner
  ! Waits for angles from a computer, as [10,0,0,0,30,0], goes there, and says so.
  CONST num PORT := 5000;
  VAR socketdev listening;
  VAR socketdev peer;

  PROC main()
    SocketCreate listening;
    SocketBind listening, "192.168.125.1", PORT;
    SocketListen listening;
    WHILE TRUE DO
      SocketAccept listening, peer \Time:=WAIT_MAX;
      serve;
    ENDWHILE
  ENDPROC

  PROC serve()
    VAR string line;
    VAR jointtarget goal := [[0, 0, 0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
    VAR robjoint angles;
    WHILE TRUE DO
      SocketReceive peer \Str:=line \Time:=WAIT_MAX;
      IF StrToVal(line, angles) THEN
        goal.robax := angles;
        MoveAbsJ goal, v200, fine, tool0;
        SocketSend peer \Str:="there";
      ELSE
        SocketSend peer \Str:="no angles";
      ENDIF
    ENDWHILE
  ERROR
    IF ERRNO = ERR_SOCK_CLOSED THEN
      SocketClose peer;
      RETURN;
    ENDIF
  ENDPROC
ENDMODULE
