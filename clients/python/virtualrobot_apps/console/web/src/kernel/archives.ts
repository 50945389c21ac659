// Zip archives: what a person drops, and what is saved.
import { unzipSync, zipSync } from "three/examples/jsm/libs/fflate.module.js";
import { Code, ConnectError } from "@connectrpc/connect";
import { lastPart, endingOf, type Files } from "./file_names";
import { checkSize, megabytes } from "./uploads";
import { info } from "./world";

/** Returns the files with those of archives in place of these. */
export async function unpacked(files: Files): Promise<Files> {
  const found = new Map<string, File>();
  for (const [path, file] of files) {
    if (endingOf(path) !== ".zip") found.set(path, file);
    else for (const [inner, one] of await filesIn(file)) found.set(inner, one);
  }
  return found;
}

async function filesIn(archive: File): Promise<[string, File][]> {
  checkSize(archive.name, archive.size);
  const most = Number(info.peek()?.limits.find(({ name }) => name === "assets_bytes")?.value ?? Infinity);
  const bytes = new Uint8Array(await archive.arrayBuffer());
  let unpacks = 0;
  // The sizes that an archive tells are looked at before anything is unpacked.
  const filter = ({ name, originalSize }: { name: string; originalSize: number }) => {
    unpacks += originalSize;
    if (unpacks > most) throw new ConnectError(`${archive.name} would unpack to more than ${megabytes(most)} (limit assets_bytes)`, Code.ResourceExhausted);
    return !name.endsWith("/");
  };
  try {
    // Not in a worker: a page of ours makes none from text.
    return Object.entries(unzipSync(bytes, { filter })).map(([path, data]) => [path, new File([data as Uint8Array<ArrayBuffer>], lastPart(path))]);
  } catch (error) {
    if (error instanceof ConnectError) throw error;
    throw new ConnectError(`${archive.name} is no zip archive: ${(error as Error).message}`, Code.InvalidArgument);
  }
}

/** Returns an archive of files by path. */
export function packed(files: Record<string, Uint8Array>): Blob {
  return new Blob([zipSync(files, { level: 1 }) as Uint8Array<ArrayBuffer>], { type: "application/zip" });
}
