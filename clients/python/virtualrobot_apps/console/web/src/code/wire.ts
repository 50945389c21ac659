// The page's editor at the console's server: a language server and a debug adapter behind one WebSocket.

/** A protocol's message, as JSON. */
export type Message = Record<string, unknown>;
export type Lane = "lsp" | "dap";

interface Hearer {
  take(message: Message): void;
  /** The process has ended, or never began; with the words of why. */
  end(why: string): void;
}

const hearers: Partial<Record<Lane, Hearer>> = {};
let socket: WebSocket | undefined;
let opened: Promise<WebSocket> | undefined;

export function hear(lane: Lane, hearer: Hearer): void {
  hearers[lane] = hearer;
}

/** Sends a message; the editor's process begins with the first one. Where it has ended, the hearers are told. */
export async function send(lane: Lane, message: Message): Promise<void> {
  opened ??= open();
  const through = await opened.catch(() => undefined);
  through?.send(JSON.stringify({ [lane]: message }));
}

function open(): Promise<WebSocket> {
  return new Promise((resolve, reject) => {
    const mine = (socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/editor`));
    mine.onopen = () => resolve(mine);
    mine.onmessage = ({ data }) => {
      const [[lane, message]] = Object.entries(JSON.parse(data as string) as Record<Lane, Message>);
      hearers[lane as Lane]?.take(message);
    };
    mine.onclose = ({ reason }) => {
      if (socket === mine) socket = opened = undefined;
      reject(new Error(reason));
      for (const hearer of Object.values(hearers)) hearer.end(reason || "the console has gone");
    };
  });
}
