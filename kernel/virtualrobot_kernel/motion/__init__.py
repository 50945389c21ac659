"""Motions: geometric paths and time laws (planning), and the pure advance of one scalar (running)."""
