// What of a table is in sight: whole rows and columns beside the header and the first column, which stay.

/** Rows that a table beside a drawing shows where there is room. */
const ROWS = 4;
/** Shares of the height that a table beside a drawing takes: at most, and for `ROWS` rows. */
const [SHARE, SHARE_FOR_ROWS] = [0.5, 0.64];
/** Height that the drawing keeps (px): that of the style sheet. */
const DRAWING_PX = 96;

interface Part {
  from: number;
  to: number;
}

/** Where the room starts so that as many of `wanted` as fit are whole, the first most of all, and `parts` are not cut. */
function startOf(parts: Part[], wanted: Part[], room: number): number | null {
  const [first, ...others] = wanted;
  if (first === undefined) return null;
  let { from, to } = first;
  for (const part of others) {
    const [lower, upper] = [Math.min(from, part.from), Math.max(to, part.to)];
    if (upper - lower <= room) [from, to] = [lower, upper];
  }
  const start = parts.find((part) => part.from >= to - room);
  return Math.min(start?.from ?? from, from);
}

function rowPart({ offsetTop, offsetHeight }: HTMLElement): Part {
  return { from: offsetTop, to: offsetTop + offsetHeight };
}

function columnPart({ offsetLeft, offsetWidth }: HTMLElement): Part {
  return { from: offsetLeft, to: offsetLeft + offsetWidth };
}

/** The height that the box may take (px). */
function mostOf(box: HTMLElement, head: HTMLElement, rows: HTMLElement[], borders: number): number {
  const pane = box.parentElement;
  if (pane === null || pane.firstElementChild === box) return pane?.clientHeight ?? 0;
  const few = rows.slice(0, ROWS).reduce((sum, row) => sum + row.offsetHeight, head.offsetHeight + borders);
  const wanted_px = pane.clientHeight * Math.min(SHARE_FOR_ROWS, Math.max(SHARE, few / pane.clientHeight));
  return Math.min(wanted_px, pane.clientHeight - DRAWING_PX);
}

/** Scrolls so that `wanted` are whole under the header, and ends the box with a whole row. */
export function revealRows(root: HTMLTableElement, rows: HTMLElement[], wanted: HTMLElement[]): void {
  const [box, head] = [root.parentElement, root.tHead];
  if (box === null || head === null || box.clientHeight === 0) return;
  const borders = box.offsetHeight - box.clientHeight;
  const most = Math.floor(mostOf(box, head, rows, borders));
  const room = most - borders - head.offsetHeight;
  const parts = rows.map(rowPart);
  const end = parts.at(-1)?.to ?? 0;
  const shown = startOf(parts, wanted.map(rowPart), room) ?? head.offsetHeight + box.scrollTop;
  // No room is left empty below the last row where rows above it fit.
  const lowest = parts.find(({ from }) => from >= end - room)?.from ?? shown;
  const start = end - shown < room ? Math.min(shown, lowest) : shown;
  const last = parts.filter(({ from, to }) => from >= start && to <= start + room).at(-1);
  const height = (last?.to ?? start + room) - start + head.offsetHeight + borders;
  const limit = `${Math.ceil(height)}px`;
  if (box.style.maxHeight !== limit) box.style.maxHeight = limit;
  box.scrollTop = start - head.offsetHeight;
}

/** Scrolls so that `wanted` are whole beside the first column. */
export function revealColumns(root: HTMLTableElement, columns: HTMLElement[], wanted: HTMLElement[]): void {
  const box = root.parentElement;
  const fixed = root.tHead?.rows[0]?.cells[0]?.offsetWidth ?? 0;
  if (box === null || box.clientWidth === 0) return;
  const parts = columns.map(columnPart);
  const room = box.clientWidth - fixed;
  const start = startOf(parts, wanted.map(columnPart), room);
  if (start === null) return;
  // Room behind the last column, without which the first one in sight would be cut.
  root.style.marginRight = `${Math.max(0, start - fixed + box.clientWidth - root.offsetWidth)}px`;
  // A box that is wide enough shows the columns from the first one.
  box.scrollLeft = root.offsetWidth <= box.clientWidth ? 0 : start - fixed;
}
