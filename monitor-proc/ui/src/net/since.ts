// Since when each node of each graph has its status, also of graphs that are not shown.
import type { TextMessage } from "./protocol";

export class Since {
  private letters: string[] = [];
  private since_s: (number | null)[][] = [];

  /** Simulated time at which a node got its status (s); null where no message told the change. */
  of(at: number, node: number): number | null {
    return this.since_s[at]?.[node] ?? null;
  }

  take(message: TextMessage): void {
    if (message.t === "hello") this.forget();
    else if (message.t === "statuses")
      this.takeLetters(message.graph, message.letters, message.time_s ?? null, new Set(message.started));
  }

  forget(): void {
    this.letters = [];
    this.since_s = [];
  }

  private takeLetters(at: number, letters: string, time_s: number | null, started: Set<number>): void {
    const before = this.letters[at] ?? "";
    const known = this.since_s[at] ?? [];
    // The start of a status that is older than the first message is unknown.
    const changed_s = before === "" ? null : time_s;
    const sinceWhen = (letter: string, node: number) => (letter === before[node] ? (known[node] ?? null) : changed_s);
    this.since_s[at] = [...letters].map((letter, node) => (started.has(node) ? time_s : sinceWhen(letter, node)));
    this.letters[at] = letters;
  }
}
