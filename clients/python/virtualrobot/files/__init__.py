"""Files: found on this machine, sent to the kernel with all that they name, and written here."""
