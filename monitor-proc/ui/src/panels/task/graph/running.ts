// The nodes that run now, each a button that leads to its place in the graph.
import type { Store } from "../../../net/store";
import { el, plainButton } from "../../dom";
import { words } from "../../format";

/** More would take the room of the graph. */
const SHOWN = 6;

export interface Running {
  root: HTMLElement;
  show: () => void;
}

/** The running nodes of the graph `index()` of which no child runs. */
function deepest(store: Store, index: number): number[] {
  const graph = store.graphs[index];
  const letters = store.letters[index] ?? "";
  if (graph === undefined) return [];
  const parents = graph.nodes.flatMap(({ parent }, node) => (letters[node] === "R" ? [parent] : []));
  const above = new Set<number | null>(parents);
  return graph.nodes.flatMap((_, node) => (letters[node] === "R" && !above.has(node) ? [node] : []));
}

export function runningNow(store: Store, index: () => number, select: (node: number) => void): Running {
  const list = el("span", { class: "row" });
  const attrs = { class: "running-now", role: "group", "aria-label": "Running now" };
  const root = el("div", attrs, el("span", { class: "dim" }, "Running now"), list);
  let shown = "";
  const show = () => {
    const nodes = deepest(store, index());
    const key = `${index()} ${nodes.join(" ")}`;
    if (key === shown) return;
    shown = key;
    const buttons = nodes.slice(0, SHOWN).map((node) => {
      const name = store.graphs[index()]?.nodes[node]?.name ?? "";
      const attrs = { class: "button small quiet", title: `Show ${name} in the graph` };
      return plainButton(attrs, () => select(node), words(name));
    });
    const more = nodes.length - buttons.length;
    const none = el("span", { class: "dim" }, "nothing");
    list.replaceChildren(...(buttons.length > 0 ? buttons : [none]), more > 0 ? ` and ${more} more` : "");
  };
  return { root, show };
}
