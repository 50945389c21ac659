// Names of files as files name each other, and which file of some that a person gave is meant.

export type Files = ReadonlyMap<string, File>;

/** Returns the ending of a name in lower case, with its point; "" for none. */
export function endingOf(name: string): string {
  return /\.[^./\\]+$/.exec(name)?.[0].toLowerCase() ?? "";
}

export function lastPart(path: string): string {
  return path.split("/").at(-1) ?? path;
}

/** Returns the one name of what the file `referrer` names as `uri`: relative names count from its folder. */
export function joinNames(referrer: string, uri: string): string {
  const named = uri.replaceAll("\\", "/");
  if (/^[a-z][a-z0-9+.-]*:/i.test(named) || named.startsWith("/")) return named;
  const [scheme, path] = /^(.*:\/\/)?(.*)$/.exec(referrer)!.slice(1);
  const parts: string[] = [];
  for (const part of [...path.split("/").slice(0, -1), ...named.split("/")]) {
    if (part === ".." && parts.length > 0 && parts.at(-1) !== "..") parts.pop();
    else if (part !== "." && part !== "") parts.push(part);
  }
  return (scheme ?? "") + parts.join("/");
}

/**
 * Returns the path of the file that is meant by a name: the one that shares the longest end with it. So `package://arm/meshes/a.stl`
 * is `arm/meshes/a.stl`, else `meshes/a.stl`, else the only `a.stl` that there is.
 */
export function findNamed(files: Files, name: string): string | undefined {
  const parts = name.replace(/^[a-z][a-z0-9+.-]*:\/*/i, "").split("/").filter(Boolean);
  for (let from = 0; from < parts.length; from++) {
    const end = parts.slice(from).join("/");
    const found = [...files.keys()].filter((path) => path === end || path.endsWith(`/${end}`));
    if (found.length > 0) return found.length === 1 ? found[0] : undefined;
  }
  return undefined;
}
