// Guards and blackboard keys with their values; what changed lately flashes, and what
// was not asked lately is dim and says how long ago it was.
import type { Store } from "../../net/store";
import type { PanelContext } from "../context";
import { el, setText, setTitle } from "../dom";
import { term } from "../terms";
import { breakDot } from "./breaks/dot";
import type { GraphChoice } from "./choice";

/** A key that was set later than this needs no age (s). */
const FRESH_S = 1;
const FLASH = { frames: [{ background: "#58a6ff55" }, {}], ms: 1200 };

export interface Value {
  text: string;
  /** How old it is, in words; empty for one that is current. */
  age: string;
  dim: boolean;
  /** It was asked or set within the last second. */
  fresh: boolean;
  about: string;
}

interface Row {
  row: HTMLElement;
  value: HTMLElement;
  age: HTMLElement;
}

class Table {
  readonly root = el("div", { class: "values" });
  private readonly cells = new Map<string, Row>();

  constructor(private readonly gutter: ((name: string) => HTMLElement) | null) {}

  /** `quiet`: another graph is shown, which is no news of its values. */
  show(values: Map<string, Value>, quiet: boolean): void {
    // Values that are unknown at the moment shown are removed.
    for (const [name, { row }] of this.cells) {
      if (values.has(name)) continue;
      row.remove();
      this.cells.delete(name);
    }
    for (const [name, { text, age, dim, fresh, about }] of [...values].sort(([a], [b]) => (a < b ? -1 : 1))) {
      const known = this.cells.get(name) ?? this.add(name);
      known.row.classList.toggle("old", dim);
      setText(known.age, age);
      setTitle(known.value, about);
      if (known.value.textContent === text) continue;
      setText(known.value, text);
      if (fresh && !quiet) flash(known.row);
    }
  }

  clear(): void {
    this.cells.clear();
    this.root.replaceChildren();
  }

  get size(): number {
    return this.cells.size;
  }

  private add(name: string): Row {
    const value = el("code", {});
    const age = el("span", { class: "age num" });
    const key = el("span", { class: "key", title: name }, this.gutter?.(name) ?? null, name);
    const row = el("div", { class: "value-row" }, key, el("span", { class: "held" }, value, age));
    const cell = { row, value, age };
    this.cells.set(name, cell);
    const after = [...this.cells.keys()].sort();
    const next = after[after.indexOf(name) + 1];
    this.root.insertBefore(row, next === undefined ? null : (this.cells.get(next)?.row ?? null));
    return cell;
  }
}

export function valueTables(context: PanelContext, choice: GraphChoice): HTMLElement {
  const { store } = context;
  const guards = new Table((name) => breakDot(context, name, 0));
  const keys = new Table(null);
  const empty = el("p", { class: "dim hint" }, "No guard was asked and no key set yet.");
  const show = (quiet: boolean) => {
    guards.show(guardValues(store, choice), quiet);
    keys.show(keyValues(store, choice.index), quiet);
    empty.hidden = guards.size + keys.size > 0;
  };
  const begin = () => {
    guards.clear();
    keys.clear();
    show(true);
  };
  const head = (name: string, key: string, table: Table) =>
    el("div", { class: "value-group" }, el("h4", {}, term(name, key)), table.root);
  const groups = [head("Guards", "guard", guards), head("Keys", "keys", keys)];
  const root = el("div", { class: "value-tables scroll", tabindex: 0 }, empty, ...groups);
  choice.on(begin);
  store.on("graph", () => show(false));
  context.pulse.add(root, () => show(false));
  begin();
  return root;
}

/** An animation of the style sheet would begin again whenever the row is shown again. */
function flash(row: HTMLElement): void {
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) row.animate(FLASH.frames, FLASH.ms);
}

function isFresh(since_s: number | null): boolean {
  return since_s !== null && since_s <= FRESH_S;
}

function guardValues(store: Store, choice: GraphChoice): Map<string, Value> {
  const at = choice.index;
  const held = Object.entries(store.guards[at] ?? {});
  return new Map(
    held.map(([name, holds]) => {
      const dim = !store.ages.isCurrent(at, name, choice.graph, store.letters[at] ?? "");
      const since = store.ages.ofGuard(at, name);
      const age = dim ? (since === null ? "earlier" : `${since.toFixed(1)} s ago`) : "";
      const about = dim ? "Not asked since the state changed, or with the same answer" : "Asked in this state";
      return [name, { text: `${dim ? "last " : ""}${holds}`, age, dim, fresh: !dim && isFresh(since), about }];
    }),
  );
}

function keyValues(store: Store, at: number): Map<string, Value> {
  const first = store.keys[0] ?? {};
  const all = { ...sharedKeys(store), ...store.keys[at] };
  return new Map(
    Object.entries(all).map(([name, text]) => {
      const own = name in (store.keys[at] ?? {}) || !(name in first);
      const since = store.ages.ofKey(own ? at : 0, name);
      const about = since === null ? text : `${text}\nset ${since.toFixed(1)} s ago (simulated time)`;
      const fresh = isFresh(since);
      const age = since === null || fresh ? "" : `${since.toFixed(0)} s`;
      return [name, { text, age, dim: false, fresh, about }];
    }),
  );
}

/** Keys of boards that several trees share; they come with the first graph. */
export function sharedKeys(store: Store): Record<string, string> {
  const first = Object.entries(store.keys[0] ?? {});
  return Object.fromEntries(first.filter(([name]) => !name.startsWith("local.")));
}
