/** The connection to a kernel: typed calls over @grpc/grpc-js, and refusals with their reason. */

import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import type {
  DescMessage,
  DescMethodServerStreaming,
  DescMethodUnary,
  MessageInitShape,
  MessageShape,
} from "@bufbuild/protobuf";
import { anyUnpack } from "@bufbuild/protobuf/wkt";
import { Client, Metadata, credentials, status } from "@grpc/grpc-js";
import type { ServiceError } from "@grpc/grpc-js";
import { ErrorInfoSchema } from "./generated/google/rpc/error_details_pb.js";
import { StatusSchema } from "./generated/google/rpc/status_pb.js";
import { ErrorReason } from "./generated/virtualrobot/v1/errors_pb.js";

const DEADLINE_MILLISECONDS = 60_000;
/**
 * What a reader leaves unread waits in this window (and in 16 KiB of Node's own), where the kernel cannot skip it.
 * Measured with a reader of 36 out of 250 states a second: 2.4 s late, and up to 7.6 s with the default of 64 KiB.
 */
const STREAM_WINDOW_BYTES = 4096;

/** A call that the kernel refused; nothing has changed in the world. */
export class Refusal extends Error {
  constructor(
    message: string,
    /** The gRPC status, such as `NOT_FOUND`. */
    readonly code: string,
    readonly reason: ErrorReason,
    /** The bad and the valid values by name. */
    readonly metadata: Readonly<Record<string, string>>,
  ) {
    super(message);
    this.name = ErrorReason[reason];
  }
}

/** A channel to one kernel. A method is a value of the generated services, such as `SceneService.method.getScene`. */
export class Kernel {
  readonly #channel: Client;
  readonly #metadata = new Metadata();

  /** Connects to `host:port`: in the clear on this machine, by TLS beyond it, so that no token travels in the clear. */
  constructor(address: string, token?: string) {
    const local = /^(127\.\d+\.\d+\.\d+|localhost|\[::1\]):\d+$/.test(address);
    this.#channel = new Client(address, local ? credentials.createInsecure() : credentials.createSsl(), {
      // A proxy set for the web must not stand between programs on one machine.
      "grpc.enable_http_proxy": local ? 0 : 1,
      "grpc.max_receive_message_length": 256 * 1024 * 1024,
      "grpc-node.flow_control_window": STREAM_WINDOW_BYTES,
    });
    if (token) this.#metadata.set("authorization", `Bearer ${token}`);
  }

  /** Makes a call with one answer; throws a `Refusal`, or gRPC's own error when no kernel answers. */
  call<I extends DescMessage, O extends DescMessage>(
    method: DescMethodUnary<I, O>,
    request: MessageInitShape<I>,
  ): Promise<MessageShape<O>> {
    return new Promise((resolve, reject) => {
      this.#channel.makeUnaryRequest(
        path(method),
        encoder(method.input),
        decoder(method.output),
        create(method.input, request),
        this.#metadata,
        { deadline: Date.now() + DEADLINE_MILLISECONDS },
        (error, response) => {
          if (response) resolve(response);
          else reject(error ? translated(error) : new Error(`${path(method)} had no answer`));
        },
      );
    });
  }

  /** Yields the messages of a watch until the kernel ends it, the loop is left or `signal` is aborted. */
  async *watch<I extends DescMessage, O extends DescMessage>(
    method: DescMethodServerStreaming<I, O>,
    request: MessageInitShape<I>,
    signal?: AbortSignal,
  ): AsyncGenerator<MessageShape<O>, void, undefined> {
    const stream = this.#channel.makeServerStreamRequest(
      path(method),
      encoder(method.input),
      decoder(method.output),
      create(method.input, request),
      this.#metadata,
    );
    const cancel = () => stream.cancel();
    // The loop below sees errors too; but those after it (our own cancel) would end the process without a listener.
    stream.on("error", () => {});
    signal?.addEventListener("abort", cancel);
    if (signal?.aborted) cancel();
    try {
      // Node's type for a stream in a loop is `any`; what comes out is what `decoder` made.
      for await (const message of stream as AsyncIterable<MessageShape<O>>) yield message;
    } catch (error) {
      if (!signal?.aborted) throw isServiceError(error) ? translated(error) : error;
    } finally {
      signal?.removeEventListener("abort", cancel);
      cancel();
    }
  }

  close(): void {
    this.#channel.close();
  }
}

function path(method: { parent: { typeName: string }; name: string }): string {
  return `/${method.parent.typeName}/${method.name}`;
}

function encoder<T extends DescMessage>(schema: T): (message: MessageShape<T>) => Buffer {
  return (message) => Buffer.from(toBinary(schema, message));
}

function decoder<T extends DescMessage>(schema: T): (bytes: Buffer) => MessageShape<T> {
  return (bytes) => fromBinary(schema, bytes);
}

function isServiceError(error: unknown): error is ServiceError {
  return error instanceof Error && "code" in error && "metadata" in error && error.metadata instanceof Metadata;
}

/** Returns the refusal whose `google.rpc.ErrorInfo` an error carries, or the error itself when it carries none. */
function translated(error: ServiceError): Error {
  const [bytes] = error.metadata.get("grpc-status-details-bin");
  if (!(bytes instanceof Buffer)) return error;
  const { message, details } = fromBinary(StatusSchema, bytes);
  for (const detail of details) {
    const info = anyUnpack(detail, ErrorInfoSchema);
    if (info?.domain === "virtualrobot") {
      return new Refusal(message, status[error.code], reasonOf(info.reason), info.metadata);
    }
  }
  return error;
}

/** The contract sends a reason's name without its prefix; a newer kernel may send one that is not known here. */
function reasonOf(name: string): ErrorReason {
  return ErrorReason[name as keyof typeof ErrorReason] ?? ErrorReason.UNSPECIFIED;
}
