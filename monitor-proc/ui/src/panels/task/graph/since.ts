// Since when each node of each graph has its status, also of graphs that are not shown.
import type { Store } from "../../../net/store";

export class Since {
  private letters: string[] = [];
  private since_s: (number | null)[][] = [];

  constructor(private readonly store: Store) {
    // What is told next was so before, since a time that is not known.
    const forget = () => {
      this.letters = [];
      this.since_s = [];
    };
    for (const what of ["hello", "graphs", "moment"] as const) store.on(what, forget);
    store.on("graph", (at) => this.take(at));
  }

  /** Simulated time at which a node got its status (s); null where no message told the change. */
  of(at: number, node: number): number | null {
    return this.since_s[at]?.[node] ?? null;
  }

  private take(at: number): void {
    const letters = this.store.letters[at] ?? "";
    const before = this.letters[at] ?? "";
    if (letters === before) return;
    const now = this.store.snapshot?.time ?? null;
    const known = this.since_s[at] ?? [];
    this.since_s[at] = [...letters].map((letter, node) => (letter === before[node] ? (known[node] ?? null) : before === "" ? null : now));
    this.letters[at] = letters;
  }
}

const all = new WeakMap<Store, Since>();

export function sinceOf(store: Store): Since {
  const known = all.get(store) ?? new Since(store);
  all.set(store, known);
  return known;
}
