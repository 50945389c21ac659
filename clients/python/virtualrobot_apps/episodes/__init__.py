"""Demonstrations: recorded as MCAP, made a dataset that learning libraries read, and played back."""
