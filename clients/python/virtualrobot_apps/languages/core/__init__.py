"""Parts that all languages share: sources, diagnostics, tasks, and the queue of motions of a program."""
