"""The component `mujoco`: physics by MuJoCo."""
