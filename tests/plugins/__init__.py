"""Plugins for the tests, good and wrong ones; `install` puts them where a process finds them."""
