// When each guard was asked last, and when each key was set, in simulated time. An
// answer that stays the same arrives again every half second at most. A message
// without a time describes a state that began earlier.
import type { Graph, TextMessage } from "./protocol";

/** What was asked longer ago may be otherwise by now (s). */
const CURRENT_S = 1;
/** Values that follow an edge within this time came with it (s). */
const SAME_FLUSH_S = 0.5;

interface Asked {
  /** Null where the answer is known, but not its time. */
  at: number | null;
  /** Whether it was asked for the change of state that followed. */
  before: boolean;
}

interface Taken {
  at: number | null;
  /** Guards and event of the edge, until values follow it. */
  names: Set<string> | null;
}

/** The event and the guards that a label, `event [one, not other]`, names. */
export function namesOf(label: string): string[] {
  const [trigger = "", guards = ""] = label.split(/ \[|\]/);
  const asked = guards.split(", ").map((guard) => guard.replace(/^not /, ""));
  return [trigger.replace(/ \(internal\)$/, ""), ...asked].filter((name) => name !== "");
}

export class Ages {
  private guards: Record<string, Asked>[] = [];
  private keys: Record<string, number | null>[] = [];
  private edges: (Taken | undefined)[] = [];

  constructor(
    private readonly now: () => number | null,
    private readonly known: { guards: Record<string, boolean>[]; keys: Record<string, string>[] },
  ) {}

  forget(): void {
    this.guards = [];
    this.keys = [];
    this.edges = [];
  }

  /** Takes a message before the store does. */
  take(message: TextMessage): void {
    if (message.t === "edge") this.takeEdge(message.graph, message.label, message.time_s ?? null);
    else if (message.t === "guards") this.takeGuards(message.graph, message.values, message.time_s ?? null);
    else if (message.t === "keys") this.takeKeys(message.graph, message.values, message.time_s ?? null);
  }

  /** Simulated time since guard `name` was asked (s); null where that is not known. */
  ofGuard(graph: number, name: string): number | null {
    return this.since(this.guards[graph]?.[name]?.at);
  }

  /** Simulated time since key `name` was set (s); null where that is not known. */
  ofKey(graph: number, name: string): number | null {
    return this.since(this.keys[graph]?.[name]);
  }

  /** Whether the answer of guard `name` holds in the state that is active. */
  isCurrent(at: number, name: string, graph: Graph | undefined, letters: string): boolean {
    // A node that runs under its guard asks it in every decision.
    const runs =
      graph?.kind === "tree" && graph.nodes.some((node, index) => node.name === name && letters[index] === "R");
    if (runs) return this.known.guards[at]?.[name] === true;
    const asked = this.guards[at]?.[name];
    const age = this.ofGuard(at, name);
    if (asked === undefined || age === null || asked.before || age > CURRENT_S) return false;
    const changed = this.edges[at]?.at ?? null;
    return changed === null || (asked.at ?? 0) >= changed;
  }

  private since(at: number | null | undefined): number | null {
    const now = this.now();
    // After a restart of physics it is earlier than it was.
    return at == null || now === null || at > now ? null : now - at;
  }

  private takeEdge(graph: number, label: string, at: number | null): void {
    const names = new Set(namesOf(label));
    this.edges[graph] = { at, names };
    const held = this.known.guards[graph] ?? {};
    const asked = (this.guards[graph] ??= {});
    for (const name of names) {
      if (name in held) asked[name] = { at: at ?? asked[name]?.at ?? null, before: true };
    }
  }

  private takeGuards(graph: number, values: Record<string, boolean>, at: number | null): void {
    const asked = (this.guards[graph] ??= {});
    const edge = this.edges[graph];
    const withEdge = edge?.names != null && (at ?? 0) - (edge.at ?? 0) < SAME_FLUSH_S;
    for (const [name, value] of Object.entries(values)) {
      if (at === null && this.known.guards[graph]?.[name] === value && name in asked) continue;
      asked[name] = { at, before: withEdge && edge?.names?.has(name) === true };
    }
    if (edge !== undefined) edge.names = null;
  }

  private takeKeys(graph: number, values: Record<string, string>, at: number | null): void {
    const set = (this.keys[graph] ??= {});
    for (const [name, value] of Object.entries(values)) {
      if (at === null && this.known.keys[graph]?.[name] === value && name in set) continue;
      set[name] = at;
    }
  }
}
