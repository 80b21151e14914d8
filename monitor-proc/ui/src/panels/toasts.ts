// Short words in a corner, said aloud by screen readers.
import type { PanelContext } from "./context";
import { el } from "./dom";
import { openIncident } from "./incident/index";

const SHOWN_MS = 6000;
const MOST = 4;

export function mountToasts(context: PanelContext): void {
  const { store } = context;
  const place = el("div", { class: "toasts", role: "status", "aria-live": "polite" });
  document.body.append(place);
  // What happened to the processes is said at once, with its reason.
  store.on("newLines", (lines) => {
    if (store.past !== null) return;
    for (const { mark, text, incident } of lines) {
      if (incident !== undefined) store.emit("notice", { text, bad: true, incident });
      if (mark === "hand" || mark === "hand_failed") store.emit("notice", { text: text.replace(/^operator: /, ""), bad: mark === "hand_failed" });
      if (mark === "restart") store.emit("notice", { text: text.replace(/^\[\w+\] /, ""), bad: false });
    }
  });
  store.on("notice", ({ text, bad, incident }) => {
    const last = place.lastElementChild;
    if (last?.firstChild?.textContent === text) last.remove();
    const toast = el("div", { class: bad ? "toast bad" : "toast" }, incident === undefined ? el("span", {}, text) : opener(context, text, incident));
    const close = el("button", { type: "button", class: "button icon-only quiet", "aria-label": "Close" }, "×");
    close.addEventListener("click", () => toast.remove());
    toast.append(close);
    place.append(toast);
    while (place.childElementCount > MOST) place.firstElementChild?.remove();
    setTimeout(() => toast.remove(), SHOWN_MS);
  });
}

/** The text of an incident: a press opens it. */
function opener(context: PanelContext, text: string, incident: number): HTMLElement {
  const node = el("button", { type: "button", class: "event-open", title: "Open the incident" }, text);
  node.addEventListener("click", () => void openIncident(context, incident));
  return node;
}
