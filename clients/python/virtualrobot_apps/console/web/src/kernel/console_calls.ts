// What this page asks of the console's own server, beside the kernel's calls: short requests, answered in JSON.
import { Code, ConnectError } from "@connectrpc/connect";

/** Asks by GET, or by POST where something is said; throws ConnectError with the console's words where it is refused. */
export async function askConsole<T>(path: string, said?: object): Promise<T> {
  const headers = { "content-type": "application/json", "client-name": "console" };
  let answer: Response;
  try {
    answer = await fetch(path, said ? { method: "POST", headers, body: JSON.stringify(said) } : { headers });
  } catch {
    throw new ConnectError("the console has gone", Code.Unavailable);
  }
  const told = (await answer.json().catch(() => ({}))) as T & { message?: string };
  if (!answer.ok) throw new ConnectError(told.message ?? `HTTP ${answer.status}`, Code.FailedPrecondition);
  return told;
}
