// The node that was clicked: its type, and its ports.
import type { Store } from "../../net/store";
import { el } from "../dom";
import type { GraphChoice } from "./choice";

const STATUS: Record<string, string> = { R: "running", S: "succeeded", F: "failed", I: "not ticked" };

export class NodeDetail {
  readonly root = el("div", { class: "node-detail", hidden: true, "aria-live": "polite" });

  constructor(
    private readonly store: Store,
    private readonly choice: GraphChoice,
  ) {
    choice.on(() => {
      this.root.hidden = true;
    });
  }

  show(index: number): void {
    const node = this.choice.graph?.nodes[index];
    if (node === undefined) return;
    const letter = this.store.letters[this.choice.index]?.[index] ?? "I";
    const close = el("button", { type: "button", class: "button icon-only quiet", "aria-label": "Close" }, "×");
    close.addEventListener("click", () => {
      this.root.hidden = true;
    });
    const head = el(
      "div",
      { class: "row" },
      el("b", {}, node.name),
      el("span", { class: "dim" }, `${node.kind} · id ${node.id} · ${STATUS[letter] ?? letter}`),
      el("span", { class: "spacer" }),
      close,
    );
    const ports = node.detail === "" ? ["no ports"] : split(node.detail);
    const lines = ports.map((port) => el("code", { class: "port" }, port));
    this.root.replaceChildren(head, el("div", { class: "ports" }, ...lines));
    this.root.hidden = false;
  }
}

/** `a=1 b='x y' [c=2]; d` as its parts; quotes and brackets stay together. */
function split(detail: string): string[] {
  return detail.match(/(?:\[[^\]]*\]|'[^']*'|[^\s[])+/g) ?? [detail];
}
