"""Studies: a function over thousands of cells, each a set of parameters, whose results stay whatever dies meanwhile."""
