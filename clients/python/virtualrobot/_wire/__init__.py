"""Internals of the client library: the channel, the stubs, and values as messages of the contract."""
