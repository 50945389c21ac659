"""Kit for authors of plugins: hooks, interfaces of components, their values and errors, and a test kit.

A plugin is a module that an entry point of the group `virtualrobot.plugins` names. It says `api_version = "1.0"` and
registers components in functions marked with `hookimpl`.
"""
