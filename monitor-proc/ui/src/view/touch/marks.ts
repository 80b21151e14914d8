// Shown at the tool of an arm that is led by hand: the distance to the body below it, its contact
// force, and the outcome of the last request.
import { Group, Vector3 } from "three";
import type { Hand } from "../../hand/hand";
import type { Contact, ContactBody, Snapshot } from "../../net/snapshot";
import type { Store } from "../../net/store";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import { DropLine } from "../overlays/drop-line";

const LINE = 0xffd166;
/** Weaker forces are not shown (N). */
const LEAST_N = 1;
const OUTCOME_MS = 6000;
/** Shares of the limit from which a force is amber and red. */
const TONES: [number, string][] = [
  [0.8, "very"],
  [0.5, "near"],
  [0, ""],
];

export class Marks {
  readonly root = new Group();
  private readonly drop = new DropLine(LINE);
  private outcome: { text: string; arm: string; bad: boolean } | null = null;
  private timer = 0;

  constructor(
    private readonly store: Store,
    private readonly hand: Hand,
    private readonly changed: () => void,
  ) {
    this.root.add(this.drop.root);
    store.on("newLines", (lines) => {
      const last = lines.filter(({ mark }) => mark === "hand" || mark === "hand_failed").at(-1);
      if (last !== undefined && store.past === null)
        this.tell(last.text.replace(/^operator: /, ""), last.mark === "hand_failed");
    });
  }

  update(cell: Cell, snapshot: Snapshot, index: number, labels: Labels): void {
    const arm = snapshot.arms[index];
    this.root.visible = arm !== undefined && this.hand.refusal() === null;
    if (arm === undefined || !this.root.visible) return;
    const tool = new Vector3(...arm.tcp.slice(0, 3));
    const name = cell.scene.objects[arm.held ?? -1]?.name;
    const body = name === undefined ? null : cell.body(name);
    if (body === null) this.drop.from(cell, tool, labels);
    else this.drop.below(cell, body, labels);
    const force = pressure(snapshot.contacts, index, arm.held);
    if (force > LEAST_N) {
      const share = force / this.hand.contactLimit_n;
      const tone = TONES.find(([from]) => share >= from)?.[1] ?? "";
      const text = `presses with ${force.toFixed(0)} N of ${this.hand.contactLimit_n} N`;
      const label = labels.show("pressure", text, tool, `load ${tone}`);
      label.style.setProperty("--load", `${(100 * Math.min(share, 1)).toFixed(0)}%`);
    }
    if (this.outcome !== null && this.outcome.arm === cell.scene.arms[index]?.name) {
      labels.show("outcome", this.outcome.text, tool, this.outcome.bad ? "outcome number" : "outcome");
    }
  }

  private tell(text: string, bad: boolean): void {
    const arm = this.store.scene?.arms.find(({ name }) => text.startsWith(`${name} `))?.name ?? "";
    this.outcome = { text: text.slice(arm.length).trim(), arm, bad };
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      this.outcome = null;
      this.changed();
    }, OUTCOME_MS);
    this.changed();
  }
}

/** Sum of the forces on an arm and on the object it holds (N), as physics counts it. */
function pressure(contacts: Contact[], arm: number, held: number | null): number {
  const isOwn = ({ kind, index }: ContactBody) =>
    (kind === "arm" && index === arm) || (kind === "object" && index === held);
  const sum = new Vector3();
  for (const { a, b, force } of contacts) {
    if (isOwn(a) !== isOwn(b)) sum.addScaledVector(new Vector3(...force), isOwn(a) ? 1 : -1);
  }
  return sum.length();
}
