"""Walking: gaits, foot placement and support of machines with legs, planned by a client and played by the kernel."""
