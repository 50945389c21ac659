"""Tests of the bundled ray casters, beside the suite."""
