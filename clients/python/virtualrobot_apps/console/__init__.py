"""The console's server: the whole contract on one port for browsers, curl and programs without gRPC."""
