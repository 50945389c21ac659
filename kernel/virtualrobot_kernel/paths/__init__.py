"""Free ways from one configuration of an arm to another: search by OMPL, shortened, proven and made a program."""
