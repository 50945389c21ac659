"""Planning outside the world thread: robots' kinematics and motions, from a snapshot and a specification to a plan."""
