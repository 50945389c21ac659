"""A vehicle goes its rounds through a room and says what has changed there. `virtualrobot demo patrol` runs it."""
