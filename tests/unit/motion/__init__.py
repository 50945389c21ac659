"""Tests of motions: planning and running."""
