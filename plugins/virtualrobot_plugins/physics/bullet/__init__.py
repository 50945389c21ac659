"""The component `bullet`: physics by PyBullet."""
