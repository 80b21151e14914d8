// The node that was clicked: its type, its ports and its breakpoint.
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setText } from "../dom";
import { breakRefusal, breaksOf, breakTwin, toggleBreak } from "./breaks/state";

const STATUS: Record<string, string> = { R: "running", S: "succeeded", F: "failed", I: "not ticked" };

export class NodeDetail {
  readonly root = el("div", { class: "node-detail", hidden: true });
  private node = -1;

  constructor(
    private readonly desk: Desk,
    /** Index of the graph that is shown. */
    private readonly graph: () => number,
  ) {}

  hide(): void {
    this.root.hidden = true;
  }

  show(index: number): void {
    const { desk } = this;
    const node = desk.store.graphs[this.graph()]?.nodes[index];
    if (node === undefined) return;
    this.node = index;
    const close = el("button", { type: "button", class: "button icon-only quiet", "aria-label": "Close" }, "×");
    close.addEventListener("click", () => this.hide());
    const about = el("span", { class: "dim" });
    const head = el("div", { class: "row" }, el("b", {}, node.name), about, el("span", { class: "spacer" }), this.breaker(node.name), close);
    const ports = node.detail === "" ? ["no ports"] : split(node.detail);
    const lines = ports.map((port) => el("code", { class: "port" }, port));
    const tell = () => {
      const letter = desk.store.letters[this.graph()]?.[this.node] ?? "I";
      setText(about, `${node.kind} · id ${node.id} · ${STATUS[letter] ?? letter}`);
    };
    this.root.replaceChildren(head, el("div", { class: "ports" }, ...lines));
    this.root.hidden = false;
    tell();
    desk.pulse.add(about, tell);
  }

  private breaker(name: string): HTMLElement {
    const { desk } = this;
    const isSet = () => breaksOf(desk.store)?.has(name) === true;
    return button(desk, {
      label: "Break here",
      class: "small",
      name: () => (isSet() ? "Remove breakpoint" : "Break here"),
      about: () => (isSet() ? `Remove the breakpoint at ${name} (B)` : `Pause the cell at ${name} (B)`),
      twin: () => breakTwin(desk, name),
      why: () => breakRefusal(desk),
      run: () => toggleBreak(desk, name),
    });
  }
}

/** `a=1 b='x y' [c=2]; d` as its parts; quotes and brackets stay together. */
function split(detail: string): string[] {
  return detail.match(/(?:\[[^\]]*\]|'[^']*'|[^\s[])+/g) ?? [detail];
}
