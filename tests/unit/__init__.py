"""Unit tests; the tree mirrors the kernel."""
