// All calls of a page to the kernel, in one WebSocket and as JSON with the contract's names.
//
//   import { Calls } from "/calls.js";
//   const calls = new Calls();
//   const { robots } = await calls.ask("RobotService/GetRobotStates");
//   calls.open("RobotService/WatchRobotStates", { onAnswer: (answer) => show(answer.robots) }).send({});
//
// A refused call is an error with `code`, `message`, `reason` and `metadata`, as the contract tells them.

const BEGIN = 0, MESSAGE = 1, END = 2, CANCEL = 3;
const written = new TextEncoder(), read = new TextDecoder();

export class Refused extends Error {
  constructor({ code, message, details = [] }) {
    super(message);
    this.code = code;
    const told = details[0]?.debug ?? {};
    this.reason = told.reason ?? "";
    this.metadata = told.metadata ?? {};
  }
}

export class Calls {
  // `url`: of the console's calls, such as "http://127.0.0.1:8090/calls" for a page of its own. `headers`: for each call, such as { authorization: "Bearer ..." }.
  constructor(url = "/calls", headers = {}) {
    this.headers = headers;
    this.running = new Map();
    this.count = 0;
    this.socket = new WebSocket(new URL(url, location.href).href.replace(/^http/, "ws"));
    this.socket.binaryType = "arraybuffer";
    this.opened = new Promise((resolve) => (this.socket.onopen = resolve));
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      const gone = new Refused({ code: "unavailable", message: "the console has gone" });
      for (const call of this.running.values()) call.onEnd(gone);
      this.running.clear();
    };
  }

  // Begin a call; `onAnswer` gets each answer, `onEnd` nothing or what it was refused for.
  open(method, { onAnswer = () => {}, onEnd = () => {}, timeout_ms, headers = {} } = {}) {
    const number = ++this.count;
    const path = method.startsWith("/") ? method : `/virtualrobot.v1.${method}`;
    if (this.socket.readyState > WebSocket.OPEN) {
      queueMicrotask(() => onEnd(new Refused({ code: "unavailable", message: "the console has gone" })));
    } else {
      this.running.set(number, { onAnswer, onEnd });
      this.put(number, BEGIN, { method: path, json: true, timeout_ms, headers: { ...this.headers, ...headers } });
    }
    return {
      send: (request) => this.put(number, MESSAGE, request),
      end: () => this.put(number, END),
      cancel: () => this.put(number, CANCEL),
    };
  }

  // Return the answer of a method with one request and one answer.
  ask(method, request = {}, options = {}) {
    return new Promise((resolve, reject) => {
      let answer;
      const onEnd = (refused) => (refused ? reject(refused) : resolve(answer));
      const call = this.open(method, { ...options, onAnswer: (one) => (answer = one), onEnd });
      call.send(request);
      call.end();
    });
  }

  async put(number, kind, said) {
    const data = said === undefined ? new Uint8Array() : written.encode(JSON.stringify(said));
    const frame = new Uint8Array(5 + data.length);
    new DataView(frame.buffer).setUint32(0, number);
    frame[4] = kind;
    frame.set(data, 5);
    if (this.socket.readyState === WebSocket.CONNECTING) await this.opened;
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(frame);
  }

  take(data) {
    const call = this.running.get(new DataView(data).getUint32(0));
    const said = JSON.parse(read.decode(new Uint8Array(data, 5)));
    if (call === undefined) return;
    if (new Uint8Array(data)[4] === MESSAGE) {
      call.onAnswer(said);
    } else {
      this.running.delete(new DataView(data).getUint32(0));
      call.onEnd(said.error && new Refused(said.error));
    }
  }
}
