"""An arm maps a cell by laser and carries the prism that it sees to a table. `virtualrobot demo carry` runs it."""
