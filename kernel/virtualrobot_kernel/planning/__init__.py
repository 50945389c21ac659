"""From a snapshot and a wish to a plan: robots' kinematics and motions, outside the world thread."""
