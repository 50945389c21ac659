"""Recordings: what a kernel tells, written to a file that other tools open (MCAP, CSV, Parquet)."""
