"""`chain`: kinematics of any serial chain, solved numerically, compiled (numba, without the GIL)."""
