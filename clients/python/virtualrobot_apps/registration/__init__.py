"""Registration: where a real robot is for a device that measures, by touched points or a printed marker."""
