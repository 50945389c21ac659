"""The driver `loopback`: a controller that is computed, with faults on demand, for teachers and tests."""
