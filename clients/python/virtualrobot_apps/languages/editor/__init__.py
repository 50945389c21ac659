"""Editors: a language server and a debug adapter, by the protocols that editors speak."""
