// Where the bins of a job are to be set down, as its cell file has it.

export interface Slots {
  /** Middles of slots or columns (m). */
  places: [number, number][];
  /** Bins on top of each other. */
  levels: number;
  /** Height of the lowest level: its middle, or its underside for columns (m). */
  base_m: number;
}

/** Columns along each side of a stack. */
const STACK_SIDE = 3;

/** A grid of `slot_x_m` and `slot_y_m`, or a `stack` of columns at `first_m` and steps from
 * there; null where the cell file says nothing of slots. */
export function slotsOf(task: Record<string, unknown> | undefined): Slots | null {
  const [xs, ys] = [numbers(task?.slot_x_m), numbers(task?.slot_y_m)];
  const grid = xs.flatMap((x) => ys.map((y): [number, number] => [x, y]));
  if (grid.length > 0) return { places: grid, levels: 1, base_m: Number(task?.slot_z_m ?? 0) };
  const stack = task?.stack;
  if (typeof stack !== "object" || stack === null) return null;
  const table = stack as Record<string, unknown>;
  const [first, one, two] = ["first_m", "first_step_m", "second_step_m"].map((key) => numbers(table[key]));
  if (first === undefined || first.length < 3 || one?.length !== 2 || two?.length !== 2) return null;
  const steps = Array.from({ length: STACK_SIDE }, (_, step) => step);
  const along = (axis: 0 | 1, i: number, j: number) => (first[axis] ?? 0) + i * (one[axis] ?? 0) + j * (two[axis] ?? 0);
  const places = steps.flatMap((i) => steps.map((j): [number, number] => [along(0, i, j), along(1, i, j)]));
  return { places, levels: Number(table.levels ?? 1), base_m: first[2] ?? 0 };
}

function numbers(value: unknown): number[] {
  return Array.isArray(value) ? value.filter((one): one is number => typeof one === "number") : [];
}
