"""Effects of processes on parts: what they leave there, in numbers."""
