"""The bundled plugins, written against `virtualrobot_sdk` like anybody's and found by entry point like anybody's.

Nothing is imported here, so that the process of an importer does not load the solvers.
"""
