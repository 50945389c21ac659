"""History of the world: every batch that was applied, kept, found again, undone and replayed."""
