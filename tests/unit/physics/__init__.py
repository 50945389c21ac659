"""Tests of the room physics/."""
