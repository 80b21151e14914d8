// Flags of a snapshot (docs/page-protocol.md), and conditions on them.

export const PAUSED = 1;
export const TASK_PAUSED = 8;
export const NOT_LIVE = 16;

export const flag = (bit) => `(r) => (r.store.snapshot.flags & ${bit}) !== 0`;
export const noFlag = (bit) => `(r) => (r.store.snapshot.flags & ${bit}) === 0`;

/** Starts the job of a cell that was started paused: on a loaded machine the page may be there
 * only after a short job has ended. */
export async function starts({ press, until }) {
  await press("robocell resume");
  await until("the task works", (r) => r.store.status.task.outcome === "running");
}
