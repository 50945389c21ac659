"""Plugins and their components: found by entry point, described, and run in this process or in one of their own."""
