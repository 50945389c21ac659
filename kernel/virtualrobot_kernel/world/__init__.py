"""World: frozen structure, state in arrays, pure commands, one queue, one thread, immutable snapshots."""
