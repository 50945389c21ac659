"""Real robots: the kernel's side of their drivers."""
