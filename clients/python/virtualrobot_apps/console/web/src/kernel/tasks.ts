// Wishes for programs at work: their clients do them.
import { attempt } from "./messages";
import { records } from "./services";

/** Tells the client of a program to stop it, or what is answered on its pendant. */
export function fileWish(id: string, word: "stop" | "answer", text = ""): void {
  void attempt(records.fileWish({ id, word, text }));
}
