"""Changes between two scans of a place: what stands there now, and what is gone."""
