"""The compiled core: forward pass of the forest, serial chains and their inverse kinematics (numba, without the GIL).

Importing this package chooses where compiled code is kept (see `cache`), which has to happen before numba is imported.
"""

from virtualrobot_kernel.numeric import cache

cache.use_cache_directory()
