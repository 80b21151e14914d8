// The node that was clicked: its type, its ports and its breakpoint.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setText, spacer } from "../dom";
import { breakRefusal, breaksOf, breakTwin, toggleBreak } from "./breaks/state";

const STATUS: Record<string, string> = { R: "running", S: "succeeded", F: "failed", I: "not ticked" };

export class NodeDetail {
  readonly root = el("div", { class: "node-detail", hidden: true });
  private node = -1;

  constructor(
    private readonly context: PanelContext,
    /** Index of the graph that is shown. */
    private readonly graph: () => number,
  ) {}

  hide(): void {
    this.root.hidden = true;
  }

  show(index: number): void {
    const { context } = this;
    const node = context.store.graphs[this.graph()]?.nodes[index];
    if (node === undefined) return;
    this.node = index;
    const close = plainButton({ class: "button icon-only quiet", "aria-label": "Close" }, () => this.hide(), "×");
    const about = el("span", { class: "dim" });
    const name = el("b", {}, node.name);
    const head = el("div", { class: "row" }, name, about, spacer(), this.breaker(node.name), close);
    const ports = node.detail === "" ? ["no ports"] : split(node.detail);
    const lines = ports.map((port) => el("code", { class: "port" }, port));
    const tell = () => {
      const letter = context.store.letters[this.graph()]?.[this.node] ?? "I";
      setText(about, `${node.kind} · id ${node.id} · ${STATUS[letter] ?? letter}`);
    };
    this.root.replaceChildren(head, el("div", { class: "ports" }, ...lines));
    this.root.hidden = false;
    tell();
    context.pulse.add(about, tell);
  }

  private breaker(name: string): HTMLElement {
    const { context } = this;
    const isSet = () => breaksOf(context.store)?.has(name) === true;
    return button(context, {
      label: "Break here",
      class: "small",
      name: () => (isSet() ? "Remove breakpoint" : "Break here"),
      about: () => (isSet() ? `Remove the breakpoint at ${name} (B)` : `Pause the cell at ${name} (B)`),
      twin: () => breakTwin(context, name),
      why: () => breakRefusal(context),
      run: () => toggleBreak(context, name),
    });
  }
}

/** `a=1 b='x y' [c=2]; d` as its parts; quotes and brackets stay together. */
function split(detail: string): string[] {
  return detail.match(/(?:\[[^\]]*\]|'[^']*'|[^\s[])+/g) ?? [detail];
}
