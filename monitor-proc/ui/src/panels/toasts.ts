// Short words in a corner, said aloud by screen readers.
import type { PanelContext } from "./context";
import { el, plainButton } from "./dom";
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
      if (mark === "hand" || mark === "hand_failed")
        store.emit("notice", { text: text.replace(/^operator: /, ""), bad: mark === "hand_failed" });
      if (mark === "restart") store.emit("notice", { text: text.replace(/^\[\w+\] /, ""), bad: false });
    }
  });
  store.on("notice", ({ text, bad, incident }) => {
    const last = place.lastElementChild;
    if (last?.firstChild?.textContent === text) last.remove();
    const words = incident === undefined ? el("span", {}, text) : opener(context, text, incident);
    const close = plainButton({ class: "button icon-only quiet", "aria-label": "Close" }, () => toast.remove(), "×");
    const toast = el("div", { class: bad ? "toast bad" : "toast" }, words, close);
    place.append(toast);
    while (place.childElementCount > MOST) place.firstElementChild?.remove();
    setTimeout(() => toast.remove(), SHOWN_MS);
  });
}

/** The text of an incident: a press opens it. */
function opener(context: PanelContext, text: string, incident: number): HTMLElement {
  return plainButton({ class: "event-open", title: "Open the incident" }, () => openIncident(context, incident), text);
}
