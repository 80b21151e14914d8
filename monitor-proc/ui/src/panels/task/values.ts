// Guards and blackboard keys with their values; what changed lately flashes.
import type { Store } from "../../net/store";
import { el, flash, setText } from "../dom";
import type { GraphChoice } from "./choice";

class Table {
  readonly root = el("div", { class: "values" });
  private readonly cells = new Map<string, { row: HTMLElement; value: HTMLElement }>();

  show(values: Record<string, string>): void {
    // What is not known of the moment that is shown goes.
    for (const [name, { row }] of this.cells) {
      if (name in values) continue;
      row.remove();
      this.cells.delete(name);
    }
    for (const name of Object.keys(values).sort()) {
      const text = values[name] ?? "";
      const known = this.cells.get(name) ?? this.add(name);
      if (known.value.textContent === text) continue;
      setText(known.value, text);
      known.value.title = text;
      flash(known.row);
    }
  }

  clear(): void {
    this.cells.clear();
    this.root.replaceChildren();
  }

  get size(): number {
    return this.cells.size;
  }

  private add(name: string) {
    const value = el("code", {});
    const row = el("div", { class: "value-row" }, el("span", { class: "key", title: name }, name), value);
    this.cells.set(name, { row, value });
    const after = [...this.cells.keys()].sort();
    const next = after[after.indexOf(name) + 1];
    this.root.insertBefore(row, next === undefined ? null : (this.cells.get(next)?.row ?? null));
    return { row, value };
  }
}

export function valueTables(store: Store, choice: GraphChoice): HTMLElement {
  const guards = new Table();
  const keys = new Table();
  const empty = el("p", { class: "dim hint" }, "No guard was asked and no key set yet.");
  const show = () => {
    const held = Object.entries(store.guards[choice.index] ?? {});
    guards.show(Object.fromEntries(held.map(([name, holds]) => [name, holds ? "true" : "false"])));
    keys.show({ ...sharedKeys(store), ...store.keys[choice.index] });
    empty.hidden = guards.size + keys.size > 0;
  };
  const begin = () => {
    guards.clear();
    keys.clear();
    show();
  };
  choice.on(begin);
  store.on("graph", show);
  begin();
  const head = (name: string, table: Table) => el("div", { class: "value-group" }, el("h4", {}, name), table.root);
  return el("div", { class: "value-tables scroll" }, empty, head("Guards", guards), head("Keys", keys));
}

/** Keys of boards that several trees share; they come with the first graph. */
export function sharedKeys(store: Store): Record<string, string> {
  const first = Object.entries(store.keys[0] ?? {});
  return Object.fromEntries(first.filter(([name]) => !name.startsWith("local.")));
}
