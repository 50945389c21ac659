"""History: who has changed what, undo and redo, checkpoints."""
