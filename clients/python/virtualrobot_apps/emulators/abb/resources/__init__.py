"""Resources of Robot Web Services by their rooms; importing this enters all in the table."""

from virtualrobot_apps.emulators.abb.resources import execution, machine, rapid, system

ROOMS = (execution, rapid, machine, system)
"""Modules of resources, in the order of the page that tells of them."""
