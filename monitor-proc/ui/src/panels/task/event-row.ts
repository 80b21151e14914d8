// Rows of the events: equal lines that are told again and again have one row with their count.
import type { LogLine } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, plainButton, setText, setTitle } from "../dom";
import { openIncident } from "../incident/index";
import { lookAt } from "../seek";

/** A warning is looked for in so many rows: two arms may warn in turn. */
const LAST_ROWS = 6;
const WARNING = "[warning]";

interface Row {
  lines: LogLine[];
  /** The one that is shown. */
  newest: LogLine;
  time: HTMLElement;
  count: HTMLElement;
}

const rows = new WeakMap<Element, Row>();

/** Time of the newest line of a row (s). */
export function timeOf(node: Element): number {
  return rows.get(node)?.newest.time_s ?? 0;
}

/** Adds `line` to the end of `list`; to the row of an equal one where it is there. */
export function addRow(context: PanelContext, list: HTMLElement, line: LogLine, about: string): HTMLElement {
  const known = equalRow(list, line);
  const node = known ?? row(context, line, about);
  if (known !== null) rows.get(known)?.lines.push(line);
  if (node !== list.lastElementChild) list.append(node);
  return node;
}

function equalRow(list: HTMLElement, line: LogLine): HTMLElement | null {
  if (line.mark !== null || line.incident !== undefined) return null;
  let node = list.lastElementChild as HTMLElement | null;
  for (let left = line.text.startsWith(WARNING) ? LAST_ROWS : 1; node !== null && left > 0; left--) {
    const first = rows.get(node)?.lines[0];
    if (first !== undefined && first.mark === null && first.text === line.text && first.epoch === line.epoch)
      return node;
    node = node.previousElementSibling as HTMLElement | null;
  }
  return null;
}

/** Shows what `node` tells up to `until_s`. */
export function showRow(node: Element, until_s: number): void {
  const row = rows.get(node);
  const first = row?.lines[0];
  if (row === undefined || first === undefined) return;
  const said = row.lines.length === 1 ? row.lines : row.lines.filter(({ time_s }) => time_s <= until_s);
  row.newest = said.at(-1) ?? first;
  setText(row.time, row.newest.time_s.toFixed(2));
  row.count.hidden = said.length < 2;
  if (said.length < 2) return;
  setText(row.count, `×${said.length}`);
  setTitle(row.count, `${said.length} times since ${first.time_s.toFixed(2)} s`);
}

function row(context: PanelContext, line: LogLine, about: string): HTMLElement {
  const attrs = { class: "event-time num", title: "Look at this moment", tabindex: -1 };
  const time = plainButton(attrs, () => lookAt(context, made.newest));
  const count = el("b", { class: "event-count num", hidden: true });
  const text = el("span", {}, words(context, line));
  const node = el("div", { class: "event", "data-kind": line.kind, "data-about": about }, time, text, count);
  const made: Row = { lines: [line], newest: line, time, count };
  if (line.mark !== null) node.dataset.mark = line.mark;
  if (line.text.startsWith(WARNING)) node.dataset.tone = "warn";
  rows.set(node, made);
  return node;
}

function words(context: PanelContext, line: LogLine): HTMLElement | string {
  const number = line.incident;
  if (number === undefined) return line.text;
  return plainButton({ class: "event-open", tabindex: -1 }, () => openIncident(context, number), line.text);
}
