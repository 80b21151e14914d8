// Spans of what was recorded (`/api/past` of docs/page-protocol.md).
import { decodeAll, type Snapshot } from "./snapshot";

/** A span of simulated time; of the newest epoch's history where `epoch` is null. */
export interface Span {
  from_s: number;
  to_s: number;
  epoch: number | null;
}

/** The snapshots of a run whose recorder has ended. */
let known: Snapshot[] | null = null;

/** From now on spans are of `snapshots`; of what the monitor records where they are null. */
export function answerFrom(snapshots: Snapshot[] | null): void {
  known = snapshots;
}

/** The last request: the monitor refuses a second one at the same time. */
let asked: Promise<unknown> = Promise.resolve();

/** At most `count` snapshots of `span`; none where nothing of it is recorded. */
export function snapshotsOf(span: Span, count: number): Promise<Snapshot[]> {
  const found = asked.then(() => ask(span, count));
  asked = found.catch(() => []);
  return found;
}

async function ask(span: Span, count: number): Promise<Snapshot[]> {
  const { from_s, to_s, epoch } = span;
  if (known !== null) return known.filter(({ time }) => time >= from_s && time <= to_s);
  const query = new URLSearchParams({ from_s: String(from_s), to_s: String(to_s), count: String(count) });
  if (epoch !== null) query.set("epoch", String(epoch));
  const answer = await fetch(`/api/past?${query}`).catch(() => null);
  return answer?.ok === true ? decodeAll(await answer.arrayBuffer()) : [];
}
