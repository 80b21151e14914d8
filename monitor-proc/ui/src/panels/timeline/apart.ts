// Places of marks that are close together: beside each other, as near as possible to their times.

/** Further from its time a mark would be taken for one of another time (pixels). */
const FAR_PX = 24;

export interface Place {
  /** Where its time is (pixels). */
  at_px: number;
  width_px: number;
  /** May be covered by others where there is too little room for all. */
  isQuiet: boolean;
}

interface Block {
  all: Place[];
  /** From the centre of each to the beginning of the block. */
  offsets: number[];
  length_px: number;
  /** Centre of the first one. */
  from_px: number;
}

/** How far each of `places` is moved on a bar of `length_px` (pixels). */
export function movedApart(places: Place[], length_px: number): Map<Place, number> {
  let shown = [...places].sort((one, other) => one.at_px - other.at_px);
  for (;;) {
    const blocks = spread(shown, length_px);
    const covered = new Set(
      blocks.filter((block) => farthest(block) > FAR_PX).flatMap(({ all }) => all.filter(({ isQuiet }) => isQuiet)),
    );
    if (covered.size === 0) return new Map(blocks.flatMap(moves));
    shown = shown.filter((place) => !covered.has(place));
  }
}

function spread(places: Place[], length_px: number): Block[] {
  const blocks: Block[] = [];
  for (const place of places) {
    let last: Block = { all: [place], offsets: [0], length_px: place.width_px, from_px: 0 };
    last.from_px = within(last, length_px);
    for (let before = blocks.at(-1); before !== undefined && end(before) > start(last); before = blocks.at(-1)) {
      blocks.pop();
      last = joined(before, last);
      last.from_px = within(last, length_px);
    }
    blocks.push(last);
  }
  return blocks;
}

function start({ all, from_px }: Block): number {
  return from_px - (all[0]?.width_px ?? 0) / 2;
}

function end(block: Block): number {
  return start(block) + block.length_px;
}

function joined(one: Block, other: Block): Block {
  const shift = one.length_px + ((other.all[0]?.width_px ?? 0) - (one.all[0]?.width_px ?? 0)) / 2;
  return {
    all: [...one.all, ...other.all],
    offsets: [...one.offsets, ...other.offsets.map((offset) => offset + shift)],
    length_px: one.length_px + other.length_px,
    from_px: 0,
  };
}

/** Where a block is nearest to the times of its marks, and on the bar. */
function within({ all, offsets, length_px }: Block, bar_px: number): number {
  const half = (all[0]?.width_px ?? 0) / 2;
  const mean = all.reduce((sum, { at_px }, index) => sum + at_px - (offsets[index] ?? 0), 0) / all.length;
  return Math.max(Math.min(mean, bar_px - length_px + half), half);
}

function farthest(block: Block): number {
  return Math.max(...raw(block).map(([, move]) => Math.abs(move)));
}

function raw({ all, offsets, from_px }: Block): [Place, number][] {
  return all.map((place, index) => [place, from_px + (offsets[index] ?? 0) - place.at_px]);
}

/** Of too many that all have to be seen, each is seen in part. */
function moves(block: Block): [Place, number][] {
  const share = Math.min(1, FAR_PX / Math.max(farthest(block), 1));
  return raw(block).map(([place, move]) => [place, move * share]);
}
