// All calls of this page in one WebSocket, as a transport of connect-es. A browser keeps six connections to a host, each
// open watch would take one of them, and then no STOP would get out. The frames are told in docs/web.md.
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import type { DescMessage, DescMethodStreaming, DescMethodUnary, MessageInitShape } from "@bufbuild/protobuf";
import { Code, ConnectError, type StreamResponse, type Transport, type UnaryResponse } from "@connectrpc/connect";
import { AnswerQueue } from "./answer_queue";

const BEGIN = 0, MESSAGE = 1, END = 2, CANCEL = 3;
const HEAD_BYTES = 5;
const LOOK_MS = 1000;
/** Looks without a word from the console after which it is asked for one, and after which it is gone: a large answer on a slow network takes a while. */
const QUIET_LOOKS = 3, MOST_LOOKS = 20;
const TEXT = { written: new TextEncoder(), read: new TextDecoder() };
const NOTHING = new Uint8Array();

interface Call {
  take(answer: Uint8Array): void;
  end(refused?: ConnectError): void;
}

interface SaidError {
  code: string;
  message?: string;
  details?: { type: string; value: string; debug?: unknown }[];
}

export class PageCalls implements Transport {
  #socket?: WebSocket;
  #opened?: Promise<void>;
  #calls = new Map<number, Call>();
  #count = 0;
  /** How often it was looked since the console has said something. Looks are counted, not time: a page that slept has missed none. */
  #quiet = 0;
  /** Bytes that have come since the page was loaded. */
  bytes = 0;

  constructor(private readonly url: string, private readonly headers: Record<string, string> = {}) {
    setInterval(() => this.#look(), LOOK_MS);
  }

  async unary<I extends DescMessage, O extends DescMessage>(
    method: DescMethodUnary<I, O>,
    signal: AbortSignal | undefined,
    timeoutMs: number | undefined,
    header: HeadersInit | undefined,
    input: MessageInitShape<I>,
  ): Promise<UnaryResponse<I, O>> {
    const answers = new AnswerQueue();
    const call = await this.#begin(method, answers, signal, timeoutMs, header);
    call.send(toBinary(method.input, create(method.input, input)));
    call.end();
    let answer: Uint8Array | undefined;
    for await (const one of answers) answer = one;
    if (answer === undefined) throw new ConnectError("the call ended without an answer", Code.Internal);
    return { ...told(method), stream: false, message: fromBinary(method.output, answer) } as UnaryResponse<I, O>;
  }

  async stream<I extends DescMessage, O extends DescMessage>(
    method: DescMethodStreaming<I, O>,
    signal: AbortSignal | undefined,
    timeoutMs: number | undefined,
    header: HeadersInit | undefined,
    input: AsyncIterable<MessageInitShape<I>>,
  ): Promise<StreamResponse<I, O>> {
    const answers = new AnswerQueue();
    const call = await this.#begin(method, answers, signal, timeoutMs, header);
    const sent = async () => {
      for await (const request of input) call.send(toBinary(method.input, create(method.input, request)));
      call.end();
    };
    sent().catch(call.cancel);
    async function* messages() {
      try {
        for await (const one of answers) yield fromBinary(method.output, one);
      } finally {
        if (!answers.ended) call.cancel();
      }
    }
    return { ...told(method), stream: true, message: messages() } as unknown as StreamResponse<I, O>;
  }

  /** Lets the socket go; calls that run end as unavailable, and the next one opens another. */
  close(): void {
    this.#socket?.close();
  }

  async #begin(
    method: DescMethodUnary | DescMethodStreaming,
    answers: AnswerQueue,
    signal: AbortSignal | undefined,
    timeout_ms: number | undefined,
    header: HeadersInit | undefined,
  ) {
    await this.#open();
    const number = ++this.#count;
    this.#calls.set(number, answers);
    const headers = { ...this.headers, ...Object.fromEntries(new Headers(header)) };
    const path = `/${method.parent.typeName}/${method.name}`;
    this.#put(number, BEGIN, TEXT.written.encode(JSON.stringify({ method: path, headers, timeout_ms })));
    const cancel = () => {
      this.#put(number, CANCEL);
      answers.end(new ConnectError("the page has cancelled the call", Code.Canceled));
    };
    if (signal?.aborted) cancel();
    signal?.addEventListener("abort", cancel);
    return {
      cancel,
      send: (request: Uint8Array) => this.#put(number, MESSAGE, request),
      end: () => this.#put(number, END),
    };
  }

  #open(): Promise<void> {
    if (this.#opened !== undefined) return this.#opened;
    const socket = (this.#socket = new WebSocket(this.url));
    this.#quiet = 0;
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => this.#take(event.data as ArrayBuffer);
    this.#opened = new Promise((resolve, reject) => {
      socket.onopen = () => resolve();
      socket.onclose = ({ reason }) => {
        const gone = new ConnectError(reason || "the console has gone", Code.Unavailable);
        socket.onclose = null;
        this.#opened = this.#socket = undefined;
        reject(gone);
        for (const call of this.#calls.values()) call.end(gone);
        this.#calls.clear();
      };
    });
    return this.#opened;
  }

  /** Notices a network that has gone without a word: what never began is answered by the console at once, and asks the kernel for nothing. */
  #look(): void {
    if (!this.#socket || ++this.#quiet < QUIET_LOOKS) return;
    if (this.#quiet < MOST_LOOKS) return this.#put(0, BEGIN, TEXT.written.encode("{}"));
    this.#socket.onmessage = null;
    this.#socket.close();
    // A socket waits for the other end's word before it says that it is closed.
    this.#socket.onclose?.(new CloseEvent("close", { reason: "the console doesn't answer: is the network gone?" }));
  }

  #put(number: number, kind: number, data: Uint8Array = NOTHING): void {
    const frame = new Uint8Array(HEAD_BYTES + data.length);
    const view = new DataView(frame.buffer);
    view.setUint32(0, number);
    view.setUint8(4, kind);
    frame.set(data, HEAD_BYTES);
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(frame);
  }

  #take(data: ArrayBuffer): void {
    const view = new DataView(data);
    const number = view.getUint32(0);
    const call = this.#calls.get(number);
    const said = new Uint8Array(data, HEAD_BYTES);
    this.bytes += data.byteLength;
    this.#quiet = 0;
    if (view.getUint8(4) === MESSAGE) {
      call?.take(said);
      return;
    }
    this.#calls.delete(number);
    const { error } = JSON.parse(TEXT.read.decode(said)) as { error?: SaidError };
    call?.end(error && refusal(error));
  }
}

function told(method: DescMethodUnary | DescMethodStreaming) {
  return { service: method.parent, method, header: new Headers(), trailer: new Headers() };
}

const CODES = new Map(
  Object.entries(Code)
    .filter((entry): entry is [string, Code] => typeof entry[1] === "number")
    .map(([name, code]) => [name.replace(/(?<!^)[A-Z]/g, "_$&").toLowerCase(), code]),
);

function refusal({ code, message, details = [] }: SaidError): ConnectError {
  const error = new ConnectError(message ?? code, CODES.get(code) ?? Code.Unknown);
  error.details = details.map(({ type, value, debug }) => ({
    type,
    value: Uint8Array.from(atob(value), (letter) => letter.charCodeAt(0)),
    debug: debug as never,
  }));
  return error;
}

/** Returns the reason by which the contract refuses a call, "" where it tells none. */
export function reasonOf(error: unknown): string {
  return detailOf(error)?.reason ?? "";
}

/** Returns what the contract tells of a refusal under a name, "" where it tells nothing. */
export function metadataOf(error: unknown, name: string): string {
  return detailOf(error)?.metadata?.[name] ?? "";
}

function detailOf(error: unknown): { reason?: string; metadata?: Record<string, string> } | undefined {
  const [detail] = ConnectError.from(error).details as { debug?: { reason?: string; metadata?: Record<string, string> } }[];
  return detail?.debug;
}
