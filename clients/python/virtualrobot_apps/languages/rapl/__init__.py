"""RAPL-II, the language of CRS controllers: its text, its commands, and what runs it."""
