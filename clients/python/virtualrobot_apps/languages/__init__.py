"""Robots' own languages: read, checked and run against a kernel."""
