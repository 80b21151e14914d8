// Pan and zoom of every drawing, kept while the page is open: a drawing that is made
// again looks as it did.

export interface Look {
  /** Pixels per unit of the drawing. */
  scale: number;
  /** Where the origin of the drawing is (px). */
  x: number;
  y: number;
  /** Whether it always fits its place. */
  fit: boolean;
}

const all = new Map<string, Look>();

/** Pan and zoom of the drawing `key`; to be changed in place. */
export function looksOf(key: string): Look {
  const known = all.get(key) ?? { scale: 1, x: 0, y: 0, fit: true };
  all.set(key, known);
  return known;
}
