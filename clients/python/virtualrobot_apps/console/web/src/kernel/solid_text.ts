// Texts of bodies (.solid): what buttons put into them. The body is YAML in blocks or in braces, as people write it.

/** What stands for a body of its own. */
export const BODIES: Record<string, string> = {
  box: "{box: {size: [0.1, 0.1, 0.1]}}",
  cylinder: "{cylinder: {radius: 0.05, length: 0.1}}",
  cone: "{cone: {radius: 0.05, length: 0.1, top: 0.02}}",
  sphere: "{sphere: {radius: 0.05}}",
  extrude: "{extrude: {profile: {rectangle: {size: [0.1, 0.06], corner: 0.01}}, height: 0.05}}",
  lathe: "{lathe: {profile: [[0, 0], [0.05, 0], [0.05, 0.01], [0.02, 0.03], [0, 0.03]]}}",
};

/** What joins bodies: the first one that comes to those that are there. */
export const JOINED: Record<string, string> = {
  union: "{move: {solid: {box: {size: [0.05, 0.05, 0.1]}}, by: [0.05, 0, 0.05]}}",
  difference: "{cylinder: {radius: 0.02, length: 1}}",
  intersection: "{sphere: {radius: 0.06}}",
};

/** What is done to a body. */
export const AROUND: Record<string, string> = {
  move: "by: [0, 0, 0.05]",
  mirror: "normal: [1, 0, 0], copy: true",
  row: "count: 3, step: [0.12, 0, 0]",
  ring: "count: 6",
};

const HEAD = /^solid:[ \t]*/m;

/** Returns a text with a word put in: around what is selected, or else around the whole body; an empty text becomes a body. */
export function inserted(text: string, word: string, from: number, to: number): string {
  const chosen = text.slice(from, to).trim();
  if (chosen) return text.slice(0, from) + inBraces(word, chosen) + text.slice(to);
  const [before, body, after] = parted(text);
  return `${before}solid:${written(inBlocks(word, body))}${after}`;
}

function inBraces(word: string, body: string): string {
  if (BODIES[word]) return BODIES[word];
  return JOINED[word] ? `{${word}: [${body}, ${JOINED[word]}]}` : `{${word}: {solid: ${body}, ${AROUND[word]}}}`;
}

function inBlocks(word: string, body: readonly string[]): string[] {
  if (body.length === 0) return [BODIES[word] ?? inBraces(word, BODIES.box)];
  if (AROUND[word]) return [`${word}:`, "  solid:", ...body.map((line) => `    ${line}`), ...AROUND[word].split(/, (?=\w+:)/).map((line) => `  ${line}`)];
  const [join, more] = BODIES[word] ? ["union", BODIES[word]] : [word, JOINED[word]];
  // To what is joined so already it is added.
  if (body[0].trim() === `${join}:` && body.slice(1).every((line) => /^\s*(- |\s)/.test(line))) return [...body, `${/^\s*/.exec(body[1])![0]}- ${more}`];
  return [`${join}:`, ...body.map((line, place) => `${place === 0 ? "- " : "  "}${line}`), `- ${more}`];
}

/** Returns what stands before the body, its lines without their common margin, and what stands after it. */
function parted(text: string): [before: string, body: string[], after: string] {
  const head = HEAD.exec(text);
  if (!head) return [text && !text.endsWith("\n") ? `${text}\n` : text, [], ""];
  const rest = text.slice(head.index + head[0].length);
  const end = /\n(?=[^\s#])/.exec(rest);
  const lines = rest.slice(0, end ? end.index : undefined).split("\n").filter((line) => line.trim());
  const margin = Math.min(...lines.slice(rest.startsWith("\n") ? 0 : 1).map((line) => /^\s*/.exec(line)![0].length));
  const body = lines.map((line, place) => (place === 0 && !rest.startsWith("\n") ? line : line.slice(Number.isFinite(margin) ? margin : 0)));
  return [text.slice(0, head.index), body, end ? rest.slice(end.index + 1) : ""];
}

function written(body: readonly string[]): string {
  if (body.length === 1 && body[0].startsWith("{")) return ` ${body[0]}\n`;
  return `\n${body.map((line) => `  ${line}\n`).join("")}`;
}
