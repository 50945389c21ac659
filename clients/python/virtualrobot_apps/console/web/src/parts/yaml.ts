// Values of JSON as YAML in blocks, as people like to read files.
import type { JsonValue } from "@bufbuild/protobuf";

const PLAIN = /^[A-Za-z][\w-]*( [\w-]+)*$/;
const MEANS_ELSE = /^(true|false|null|yes|no|on|off|y|n|nan|inf)$/i;

/** Returns the lines of a value, which end with a line feed. */
export function yaml(value: JsonValue): string {
  return lines(value).map((line) => `${line}\n`).join("");
}

function lines(value: JsonValue): string[] {
  if (Array.isArray(value)) {
    if (value.length === 0) return ["[]"];
    return value.flatMap((one) => lines(one).map((line, place) => (place === 0 ? `- ${line}` : `  ${line}`)));
  }
  if (typeof value !== "object" || value === null) return [typeof value === "string" ? word(value) : JSON.stringify(value)];
  const entries = Object.entries(value);
  if (entries.length === 0) return ["{}"];
  return entries.flatMap(([key, one]) => {
    const inner = lines(one);
    const isBlock = typeof one === "object" && one !== null && Object.keys(one).length > 0;
    return isBlock ? [`${word(key)}:`, ...inner.map((line) => `  ${line}`)] : [`${word(key)}: ${inner[0]}`];
  });
}

function word(text: string): string {
  return PLAIN.test(text) && !MEANS_ELSE.test(text) ? text : JSON.stringify(text);
}
