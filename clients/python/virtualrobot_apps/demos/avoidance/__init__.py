"""Obstacle avoidance of an arm's links in its null space. `virtualrobot avoid` runs it."""
