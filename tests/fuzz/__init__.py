"""Coverage-guided fuzzing of what reads bytes of strangers, and the inputs that it has found."""
