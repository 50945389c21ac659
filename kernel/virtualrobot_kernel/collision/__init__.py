"""What touches and how far things are apart, by FCL: geometry made once, and pairs of placed elements."""
