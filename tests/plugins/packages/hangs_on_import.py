"""A plugin that hangs when it is imported."""

import time

time.sleep(3600.0)
