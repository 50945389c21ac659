"""The only place where messages of the contract meet the kernel's own types."""
