"""Contacts and distances, by FCL: geometry made once, and pairs of placed elements."""
