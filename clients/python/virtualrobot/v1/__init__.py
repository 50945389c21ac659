"""Generated from proto/virtualrobot/v1 by tools/generate_stubs.py; never edited."""
