"""`python -m virtualrobot` is the command line."""

from virtualrobot.cli import main

main()
