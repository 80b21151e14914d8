// The states of the last minute as coloured spans, one row an arm.
import type { Span } from "../../../net/protocol";
import type { Store } from "../../../net/store";
import type { PanelContext } from "../../context";
import { el, setAttr, setTitle } from "../../dom";
import { words } from "../../format";
import { phaseColour } from "../../phase-colour";

const SHOWN_S = 60;
/** A minute is some hundred pixels wide: it moves by less than one in this time (s). */
const STEP_S = 0.2;
/** Shorter spans have no room for their name (s). */
const NAMED_S = 6;

interface Drawn {
  span: Span;
  to_s: number;
  node: HTMLElement;
}

/** Spans of the lane with their ends; that of the last is not known yet. */
function ended(store: Store, lane: string): { span: Span; to_s: number }[] {
  const spans = store.spans.filter((span) => span.lane === lane && span.kind === "phase");
  return spans.map((span, index) => ({ span, to_s: spans[index + 1]?.from_s ?? Infinity }));
}

export interface Strip {
  root: HTMLElement;
  /** Shows the spans that are known now; a hidden strip has no pulse. */
  show: () => void;
}

export function stateStrip(context: PanelContext): Strip {
  const { store } = context;
  const root = el("div", { class: "state-strip", hidden: true });
  let drawn: Drawn[] = [];
  let known: Span[] | null = null;
  const build = (now: number) => {
    known = store.spans;
    const lanes = [...new Set(known.filter(({ kind }) => kind === "phase").map(({ lane }) => lane))];
    root.hidden = lanes.length === 0;
    drawn = [];
    root.replaceChildren(
      ...lanes.map((lane) => {
        const recent = ended(store, lane).filter(({ span, to_s }) => span.label !== "" && to_s > now - 2 * SHOWN_S);
        const spans = recent.map(({ span, to_s }) => {
          const node = el("span", { class: "state-span" }, words(span.label));
          node.style.setProperty("--phase", phaseColour(span.label));
          drawn.push({ span, to_s, node });
          return node;
        });
        const row = el("div", { class: "state-row", role: "img" }, ...spans);
        row.dataset.lane = lane;
        return row;
      }),
    );
  };
  let shown = -1;
  const show = () => {
    const now = store.snapshot?.time ?? 0;
    const isNew = known !== store.spans;
    if (!isNew && Math.abs(now - shown) < STEP_S) return;
    // Older spans are drawn only when the past is looked at.
    if (isNew || Math.abs(now - shown) > SHOWN_S) build(now);
    shown = now;
    place(drawn, now);
    for (const row of root.children) {
      const lane = (row as HTMLElement).dataset.lane ?? "";
      setAttr(row, "aria-label", `States of the last ${SHOWN_S} s, ${lane}: ${listed(drawn, row)}`);
    }
  };
  context.pulse.add(root, show);
  show();
  return { root, show };
}

function listed(drawn: Drawn[], row: Element): string {
  const inside = drawn.filter(({ node }) => node.parentElement === row && !node.hidden);
  return inside.map(({ span }) => span.label).join(", ");
}

/** Puts the spans where they are in the minute that ends at `now`. */
function place(drawn: Drawn[], now: number): void {
  const share = (time: number) => (100 * (Math.min(Math.max(time, now - SHOWN_S), now) - (now - SHOWN_S))) / SHOWN_S;
  for (const { span, to_s, node } of drawn) {
    const [left, right] = [share(span.from_s), share(to_s)];
    node.hidden = right <= left;
    node.style.left = `${left}%`;
    node.style.width = `${right - left}%`;
    const end = Math.min(to_s, now);
    setAttr(node, "data-short", end - Math.max(span.from_s, now - SHOWN_S) < NAMED_S ? "" : null);
    const lasted = `${(end - span.from_s).toFixed(1)} s`;
    setTitle(node, `${span.label}: ${span.from_s.toFixed(2)} s to ${end.toFixed(2)} s (${lasted})`);
  }
}
