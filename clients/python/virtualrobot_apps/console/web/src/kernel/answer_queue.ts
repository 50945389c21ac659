// Answers of one call in the order in which they came, for one reader.
import type { ConnectError } from "@connectrpc/connect";

export class AnswerQueue implements AsyncIterable<Uint8Array> {
  #waiting: Uint8Array[] = [];
  #refused?: ConnectError;
  #wake = () => {};
  ended = false;

  take(answer: Uint8Array): void {
    this.#waiting.push(answer);
    this.#wake();
  }

  end(refused?: ConnectError): void {
    if (this.ended) return;
    this.ended = true;
    this.#refused = refused;
    this.#wake();
  }

  async *[Symbol.asyncIterator](): AsyncGenerator<Uint8Array> {
    for (;;) {
      while (this.#waiting.length > 0) yield this.#waiting.shift()!;
      if (this.#refused) throw this.#refused;
      if (this.ended) return;
      await new Promise<void>((resolve) => (this.#wake = resolve));
    }
  }
}
