"""RAPID, the language of ABB's controllers: its text, its meaning, and what runs it."""
