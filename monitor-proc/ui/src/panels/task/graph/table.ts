// What a machine or a matrix does, as the table it was written as: the column of
// the active state and the cell or row taken last stand out.
import type { Graph } from "../../../net/protocol";
import type { Store } from "../../../net/store";
import { el, setAttr } from "../../dom";
import { term } from "../../terms";
import { lettersOf, wayOut } from "./letters";
import { revealColumns, revealRows } from "./table-scroll";
import { takenOf } from "./taken";

export interface LiveTable {
  root: HTMLElement;
  show: () => void;
  /** Brings the active state into sight. */
  follow: () => void;
}

interface Cell {
  node: HTMLElement;
  from: number;
  event: string;
}

/** Handlers by event, as a state's detail tells them: `EVENT: handler, ...`. */
function handlers(detail: string): Map<string, string> {
  const pairs = detail.split(", ").map((part) => part.split(": "));
  return new Map(pairs.filter((pair): pair is [string, string] => pair.length > 1));
}

/** All events, in an order that keeps that of every state: that of precedence. */
function order(lists: string[][]): string[] {
  const left = lists.map((list) => [...list]);
  const all: string[] = [];
  for (;;) {
    const heads = left.flatMap(([head]) => (head === undefined ? [] : [head]));
    const next = heads.find((head) => left.every((list) => list.indexOf(head) <= 0)) ?? heads[0];
    if (next === undefined) return all;
    all.push(next);
    for (const list of left) {
      const at = list.indexOf(next);
      if (at >= 0) list.splice(at, 1);
    }
  }
}

/** A long name may be broken at its underscores. */
function breakable(name: string): string {
  return name.replaceAll("_", "_\u200b");
}

function matrix(graph: Graph): { head: HTMLElement; rows: HTMLElement[]; cells: Cell[]; columns: HTMLElement[] } {
  const known = graph.nodes.map(({ detail }) => handlers(detail));
  const events = order(known.map((one) => [...one.keys()]));
  const columns = graph.nodes.map(({ name }) => el("th", { scope: "col" }, name));
  const cells: Cell[] = [];
  const rows = events.map((event) => {
    const row = graph.nodes.map((_, from) => {
      const handler = known[from]?.get(event);
      const goes = graph.edges.filter((edge) => edge.from === from && edge.label === event);
      const to = goes.map((edge) => graph.nodes[edge.to]?.name ?? "?").join(" | ");
      const node = el("td", {}, handler === undefined ? null : el("span", {}, breakable(handler)));
      if (to !== "") node.append(el("b", {}, `→ ${to}`));
      cells.push({ node, from, event });
      return node;
    });
    return el("tr", {}, el("th", { scope: "row" }, breakable(event)), ...row);
  });
  return { head: el("tr", {}, el("th", {}), ...columns), rows, cells, columns };
}

/** Whether a column or row is of the state in which the task is, or ended. */
function isActive({ dataset }: HTMLElement): boolean {
  return dataset.status !== undefined && dataset.status !== "I";
}

/** The table of a matrix: a row an event, a column a state. */
function matrixTable(store: Store, at: number, graph: Graph): LiveTable {
  const { head, rows, cells, columns } = matrix(graph);
  const root = el("table", { class: "live-table matrix" }, el("thead", {}, head), el("tbody", {}, ...rows));
  const show = () => {
    const letters = lettersOf(store, at);
    const last = takenOf(store, at);
    for (const [index, column] of columns.entries()) {
      setAttr(column, "data-status", letters[index] ?? "I");
    }
    for (const { node, from, event } of cells) {
      setAttr(node, "data-status", letters[from] ?? "I");
      node.classList.toggle("last", last?.from === from && last.label === event);
    }
  };
  const follow = () => {
    const last = cells.find(({ node }) => node.classList.contains("last"))?.node;
    const isNamed = ({ node }: Cell) => isActive(node) && node.childElementCount > 0;
    const active = cells.filter(isNamed).flatMap(({ node }) => node.parentElement ?? []);
    const at = columns.find((column) => isActive(column));
    revealRows(root, rows, [last?.parentElement ?? [], ...active].flat());
    revealColumns(root, columns, [at ?? [], last ?? []].flat());
  };
  return { root, show, follow };
}

/** How the machine ended in a state; null where it did not. */
function endOf(letter: string | undefined): string | null {
  return letter === "S" || letter === "F" ? letter : null;
}

/** The table of a machine: a row a transition. */
function rowsTable(store: Store, at: number, graph: Graph): LiveTable {
  const name = (index: number) => graph.nodes[index]?.name ?? "?";
  const rows = graph.edges.map((edge) => {
    const [trigger = "", guard = ""] = edge.label.split(/ \[|\]/);
    const [start, end] = [el("td", {}, name(edge.from)), el("td", {}, `→ ${name(edge.to)}`)];
    const when = [el("td", {}, breakable(trigger)), el("td", { class: "dim" }, breakable(guard))];
    const node = el("tr", {}, start, end, ...when);
    return { edge, node, start, end };
  });
  const head = ["from", "to", "trigger", "guard"].map((text) => el("th", { scope: "col" }, term(text)));
  const root = el(
    "table",
    { class: "live-table" },
    el("thead", {}, el("tr", {}, ...head)),
    el("tbody", {}, ...rows.map(({ node }) => node)),
  );
  const show = () => {
    const letters = lettersOf(store, at);
    const last = takenOf(store, at);
    for (const { edge, node, start, end } of rows) {
      setAttr(node, "data-status", wayOut(letters[edge.from]));
      const same = last?.from === edge.from && last.to === edge.to && last.label === edge.label;
      node.classList.toggle("last", same);
      // The state in which the machine ended; only the way that led there ends in it.
      setAttr(start, "data-end", endOf(letters[edge.from]));
      setAttr(end, "data-end", same ? endOf(letters[edge.to]) : null);
    }
  };
  const follow = () => {
    const nodes = rows.map(({ node }) => node);
    const active = nodes.filter(isActive);
    const last = nodes.find((node) => node.classList.contains("last"));
    const ended = rows.filter(({ start }) => start.dataset.end !== undefined).map(({ node }) => node);
    const [first, ...others] = active;
    revealRows(root, nodes, [first ?? [], last ?? [], ...others, ...ended].flat());
  };
  return { root, show, follow };
}

/** The table of graph `at`. */
export function liveTable(store: Store, at: number, graph: Graph): LiveTable {
  return graph.kind === "matrix" ? matrixTable(store, at, graph) : rowsTable(store, at, graph);
}
