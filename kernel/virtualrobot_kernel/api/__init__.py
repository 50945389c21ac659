"""Server of the contract: grpc.aio in its own thread; servicers are thin, `convert` alone knows both sides' types."""
