// Operator or viewer, and how a viewer becomes an operator.
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { popover } from "../popover";

const OTHER = "that is not the operator's token";
const ABOUT =
  "The address that `robocell run` prints ends with the operator's token. With it, this page may also command.";

export function roleBadge(context: PanelContext): HTMLElement {
  const badge = el("button", { type: "button", class: "badge role" }, "–");
  const attrs = { type: "password", autocomplete: "off", spellcheck: "false", placeholder: "operator token" };
  const token = el("input", { ...attrs, "aria-label": "Operator token" });
  const form = el(
    "form",
    {},
    el("p", {}, ABOUT),
    el("div", { class: "row" }, token, el("button", { class: "button primary" }, "Present")),
  );
  const sheet = el("div", { class: "role-sheet" }, form);
  popover(badge, sheet);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    void present(context, token.value.trim());
    token.value = "";
  });
  const show = () => {
    const role = context.store.hello?.role;
    // A recording cannot be commanded; a viewer may still get the right to play it.
    badge.hidden = context.store.hello?.live === false && role !== "viewer";
    setText(badge, role ?? "–");
    // A cell that has ended takes no commands.
    setAttr(badge, "data-tone", role === undefined || context.isStale ? null : role === "operator" ? "ok" : "warn");
    const viewer = "You may look only; click to present the operator's token";
    setTitle(badge, role === "operator" ? "You may command the cell" : viewer);
  };
  context.store.on("hello", show);
  context.store.on("connection", show);
  show();
  return el("span", { class: "with-popover" }, badge, sheet);
}

async function present(context: PanelContext, token: string): Promise<void> {
  try {
    const answer = await fetch("/api/token", {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify({ token }),
    });
    // The socket keeps the role it was opened with.
    if (answer.ok) location.reload();
    else context.notify(answer.status === 403 ? OTHER : `refused (${answer.status})`, true);
  } catch {
    context.notify("the monitor does not answer", true);
  }
}
