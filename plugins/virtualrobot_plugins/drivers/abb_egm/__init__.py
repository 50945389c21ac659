"""The driver `abb_egm`: ABB robots by Externally Guided Motion."""
