"""Inputs of a tick: the mailbox of all that write to the world at the rate of ticks."""
