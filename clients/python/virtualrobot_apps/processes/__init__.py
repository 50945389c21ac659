"""Industrial processes: where a tool goes on a part, and what happens there; clients of the kernel like any other."""
