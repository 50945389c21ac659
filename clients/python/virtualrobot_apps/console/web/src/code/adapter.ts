// Client of the debug adapter (Debug Adapter Protocol): requests and their answers, and what it tells by itself.
import { hear, send, type Message } from "./wire";

/** What is told besides answers: an event's name and body; `ended` is the end of the adapter's process. */
type Hearer = (event: string, body: Message) => void;

const waiting = new Map<number, { resolve: (body: Message) => void; reject: (error: Error) => void }>();
let count = 0;
let told: Hearer = () => undefined;

hear("dap", {
  take({ type, event, body, request_seq: of, success, message }: Message) {
    if (type === "event") return told(event as string, (body ?? {}) as Message);
    const asked = waiting.get(of as number);
    waiting.delete(of as number);
    if (success) asked?.resolve((body ?? {}) as Message);
    else asked?.reject(new Error(message as string));
  },
  end(why) {
    for (const { reject } of waiting.values()) reject(new Error(why));
    waiting.clear();
    told("ended", { why });
  },
});

export function hearEvents(hearer: Hearer): void {
  told = hearer;
}

/** Returns the body of the answer; throws why there is none. */
export function request<T = Message>(command: string, given: Message = {}): Promise<T> {
  const seq = ++count;
  void send("dap", { seq, type: "request", command, arguments: given });
  return new Promise((resolve, reject) => waiting.set(seq, { resolve: resolve as (body: Message) => void, reject }));
}
