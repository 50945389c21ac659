"""The contract served: grpc.aio in a thread of its own; servicers are thin, `convert` alone knows both sides' types."""
