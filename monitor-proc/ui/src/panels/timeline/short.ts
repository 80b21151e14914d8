// Names of objects where there is little room: what tells one from the others is kept.

/** By name: what is left without the first and last words that all names have. */
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

/** `name` in so many letters; else its `own` part, which is shortened in the middle. */
export function shortened(name: string, own: string, letters: number): string {
  if (name.length <= letters) return name;
  if (own.length <= letters) return own;
  const room = Math.floor(letters) - 1;
  if (room < 2) return "";
  const head = Math.floor(room / 2);
  return `${own.slice(0, head)}…${own.slice(head - room)}`;
}
