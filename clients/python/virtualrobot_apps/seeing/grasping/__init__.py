"""Grasps of parallel jaws on meshes and clouds."""
