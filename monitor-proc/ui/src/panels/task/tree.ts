// A behaviour tree as lines that are indented, with the status of each node.
import type { Graph } from "../../net/protocol";
import type { Store } from "../../net/store";
import type { Pulse } from "../pulse";
import { el, reveal, setAttr, setText } from "../dom";

/** Signs of the composites, as on the command line. */
const SIGNS: Record<string, string> = { sequence: "→", selector: "?", parallel: "⇉" };
const MARKS: Record<string, [string, string]> = {
  R: ["▶", "running"],
  S: ["✓", "succeeded"],
  F: ["✗", "failed"],
};

/** Depth of each node: parents stand before their children. */
function depths(graph: Graph): number[] {
  const all: number[] = [];
  for (const [index, node] of graph.nodes.entries()) {
    const parent = node.parent;
    all.push(parent !== null && parent < index ? (all[parent] ?? 0) + 1 : 0);
  }
  return all;
}

export interface GraphView {
  root: Element;
  /** Shows the newest statuses and the last edge. */
  show: () => void;
  /** Brings the running node into sight. */
  follow: () => void;
}

export function treeView(store: Store, pulse: Pulse | null, at: number, onNode: (node: number) => void): GraphView {
  const graph = store.graphs[at];
  const root = el("div", { class: "tree", role: "list" });
  if (graph === undefined) return { root, show: () => {}, follow: () => {} };
  const depth = depths(graph);
  const since: (number | null)[] = graph.nodes.map(() => null);
  const rows = graph.nodes.map((node, index) => {
    const mark = el("span", { class: "mark" });
    const time = el("span", { class: "num dim" });
    const sign = SIGNS[node.kind.toLowerCase()] ?? "";
    const says = node.kind.toLowerCase() !== node.name.toLowerCase() && sign === "";
    const row = el(
      "button",
      { type: "button", class: "tree-node", title: [node.kind, node.detail].join("\n").trim() },
      mark,
      el("span", { class: "sign" }, sign),
      el("span", { class: "name" }, node.name),
      el("span", { class: "dim kind" }, says ? node.kind : ""),
      time,
    );
    row.style.setProperty("--depth", String(depth[index]));
    row.addEventListener("click", () => onNode(index));
    root.append(row);
    return { row, mark, time };
  });
  let deepest = -1;
  const show = () => {
    const letters = store.letters[at] ?? "";
    let running = -1;
    for (const [index, { row, mark }] of rows.entries()) {
      const letter = letters[index] ?? "I";
      if (letter === "R") running = index;
      if (row.dataset.status === letter) continue;
      row.dataset.status = letter;
      since[index] = letter === "R" ? (store.snapshot?.time ?? null) : null;
      const [sign, word] = MARKS[letter] ?? ["·", "not ticked"];
      setText(mark, sign);
      setAttr(mark, "aria-label", word);
    }
    deepest = running;
  };
  pulse?.add(root, () => {
    const now = store.snapshot?.time ?? 0;
    for (const [index, { time }] of rows.entries()) {
      const begun = since[index];
      setText(time, begun == null || now < begun ? "" : `${(now - begun).toFixed(1)} s`);
    }
  });
  return { root, show, follow: () => reveal(root.closest(".graph-body"), rows[deepest]?.row) };
}
