// Which subtrees are collapsed, remembered for every picture of the same tree.

export class Folds {
  private readonly shut = new Set<string>();
  private readonly listeners = new Set<() => void>();

  has(id: string): boolean {
    return this.shut.has(id);
  }

  /** Calls `listener` when a subtree is collapsed or expanded. */
  on(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  toggle(id: string): void {
    this.set(id, !this.shut.has(id));
  }

  set(id: string, shut: boolean): void {
    if (shut === this.shut.has(id)) return;
    if (shut) this.shut.add(id);
    else this.shut.delete(id);
    for (const listener of [...this.listeners]) listener();
  }
}

const all = new Map<string, Folds>();

export function foldsOf(key: string): Folds {
  const known = all.get(key) ?? new Folds();
  all.set(key, known);
  return known;
}
