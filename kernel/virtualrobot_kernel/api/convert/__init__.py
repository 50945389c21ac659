"""Conversion between messages of the contract and the kernel's own types, which meet nowhere else."""
