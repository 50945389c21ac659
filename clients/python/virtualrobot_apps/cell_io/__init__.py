"""Signals of a cell and the outside: what connections, bridges and cell programs share."""
