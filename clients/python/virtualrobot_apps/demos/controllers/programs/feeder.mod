MODULE Feeder
  ! Brings a part, and waits until somebody has it.
  PERS num parts := 0;
  CONST jointtarget home := [[0, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget there := [[40, 20, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];

  PROC main()
    MoveAbsJ home, v500, fine, tool0;
    FOR i FROM 1 TO 2 DO
      MoveAbsJ there, v500, fine, tool0;
      parts := parts + 1;
      SetDO doPart, 1;
      WaitDI diTaken, 1;
      SetDO doPart, 0;
      WaitDI diTaken, 0;
      MoveAbsJ home, v500, fine, tool0;
    ENDFOR
  ENDPROC
ENDMODULE
