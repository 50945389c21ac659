"""Palletizing cell: a conveyor and two arms that talk by signals. `virtualrobot demo` runs it."""
