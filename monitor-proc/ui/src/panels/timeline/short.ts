// Names of objects where there is little room: only the words that differ are kept.

/** By name: its words without the first and last ones that all names have. */
export function ownParts(names: string[]): Map<string, string> {
  const all = names.map((name) => name.split(" "));
  const least = Math.min(...all.map(({ length }) => length)) - 1;
  const same = (at: (words: string[]) => string | undefined) => all.every((words) => at(words) === at(all[0] ?? []));
  let first = 0;
  if (all.length > 1) while (first < least && same((words) => words[first])) first++;
  let last = 0;
  if (all.length > 1) while (first + last < least && same((words) => words.at(-1 - last))) last++;
  return new Map(all.map((words) => [words.join(" "), words.slice(first, words.length - last).join(" ")]));
}

/** The font of the lanes. */
const FONT = "11px system-ui, sans-serif";
/** Fewer letters of a name tell nothing. */
const LEAST_LETTERS = 3;
/** Names of long runs are many. */
const MOST_KNOWN = 5000;

const known = new Map<string, number>();
let pen: CanvasRenderingContext2D | null = null;

function widthOf(text: string): number {
  const before = known.get(text);
  if (before !== undefined) return before;
  if (pen === null) {
    pen = document.createElement("canvas").getContext("2d");
    if (pen !== null) pen.font = FONT;
  }
  const width = Math.ceil(pen?.measureText(text).width ?? 0);
  if (known.size > MOST_KNOWN) known.clear();
  known.set(text, width);
  return width;
}

export function fits(text: string, room_px: number): boolean {
  return widthOf(text) <= room_px;
}

/** The first of `texts` that fits; else the last one, cut at its end, or nothing. */
export function fitted(texts: string[], room_px: number): string {
  if (room_px <= 0) return "";
  const whole = texts.find((text) => widthOf(text) <= room_px);
  if (whole !== undefined) return whole;
  const last = texts.at(-1) ?? "";
  for (let letters = last.length - 1; letters >= LEAST_LETTERS; letters--) {
    const text = `${last.slice(0, letters).trimEnd()}…`;
    if (widthOf(text) <= room_px) return text;
  }
  return "";
}
