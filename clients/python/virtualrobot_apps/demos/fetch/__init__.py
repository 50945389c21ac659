"""A mobile manipulator fetches from a shelf what it sees there. `virtualrobot demo fetch` runs it."""
