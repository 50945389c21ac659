"""The Modeller: bodies of a cell that a text describes, changed while they stand in it."""
