// The runs of `--loop` that this page has seen, one after the other: each seed with its outcome.
import type { PanelContext } from "../context";
import { el } from "../dom";
import { words } from "../format";

/** More would not fit beside each other. */
const KEPT_EPISODES = 40;

interface Episode {
  run: string;
  demo: string;
  seed: number;
  outcome: string;
  reason: string;
  length_s: number;
}

function drawn({ seed, outcome, reason, length_s }: Episode): HTMLElement {
  const tone = { done: "ok", failed: "bad" }[outcome] ?? "dim";
  const why = reason === "" ? "" : `: ${words(reason)}`;
  const title = `Seed ${seed}: ${outcome}${why}, ${length_s.toFixed(1)} s`;
  return el("i", { "data-tone": tone, title }, String(seed));
}

export function episodes(context: PanelContext): HTMLElement {
  const { store } = context;
  const list = el("div", { class: "episode-list" });
  const attrs = { class: "episodes", hidden: true, role: "group", "aria-label": "Earlier runs" };
  const root = el("div", attrs, el("span", { class: "lane-name" }, "seeds"), list);
  let now: Episode | null = null;
  const past: Episode[] = [];
  store.on("status", () => {
    const { hello, newest, timeline } = store;
    if (hello?.live !== true || newest === null) return;
    const { id, demo, seed } = hello.run;
    // Also while the past is looked at: the status that is shown is that of then.
    const { outcome, reason } = newest.task;
    const shown_s = store.past === null ? (store.snapshot?.time ?? 0) : 0;
    now = { run: id, demo, seed, outcome, reason, length_s: Math.max(shown_s, timeline?.to_s ?? 0) };
  });
  store.on("hello", ({ run }) => {
    if (now === null || now.run === run.id) return;
    // Another demo starts its own list.
    if (now.demo !== run.demo) past.length = 0;
    else past.push(now);
    past.splice(0, past.length - KEPT_EPISODES);
    now = null;
    list.replaceChildren(...past.map(drawn));
    root.hidden = past.length === 0;
  });
  return root;
}
