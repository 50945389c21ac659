// What the page tells people while somebody is in the room, who doesn't see the page: said there for as long as reading takes.
import { effect, signal } from "@preact/signals";
import { messages } from "../kernel/messages";

const READ_MS = 8000;

/** What was told last; "" when that was some time ago. */
export const heard = signal("");

effect(() => {
  const newest = messages.value.at(-1);
  heard.value = newest?.text ?? "";
  setTimeout(() => messages.peek().at(-1) === newest && (heard.value = ""), READ_MS);
});
