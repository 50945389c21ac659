"""Connections between signals with logic, told in a file: the IOConnection tool."""
