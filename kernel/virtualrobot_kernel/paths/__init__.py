"""Free ways of an arm from one configuration to another: searched, shortened, proven and made a program."""
