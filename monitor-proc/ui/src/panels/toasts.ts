// Short words in a corner, said aloud by screen readers.
import type { Store } from "../net/store";
import { el } from "./dom";

const SHOWN_MS = 6000;
const MOST = 4;

export function mountToasts(store: Store): void {
  const place = el("div", { class: "toasts", role: "status", "aria-live": "polite" });
  document.body.append(place);
  // What happened to the processes is said at once, with its reason.
  store.on("newLines", (lines) => {
    if (store.past !== null) return;
    for (const { mark, text } of lines) {
      if (mark === "incident") store.emit("notice", { text, bad: true });
      if (mark === "hand" || mark === "hand_failed") store.emit("notice", { text: text.replace(/^operator: /, ""), bad: mark === "hand_failed" });
      if (mark === "restart") store.emit("notice", { text: text.replace(/^\[\w+\] /, ""), bad: false });
    }
  });
  store.on("notice", ({ text, bad }) => {
    const last = place.lastElementChild;
    if (last?.firstChild?.textContent === text) last.remove();
    const toast = el("div", { class: bad ? "toast bad" : "toast" }, el("span", {}, text));
    const close = el("button", { type: "button", class: "button icon-only quiet", "aria-label": "Close" }, "×");
    close.addEventListener("click", () => toast.remove());
    toast.append(close);
    place.append(toast);
    while (place.childElementCount > MOST) place.firstElementChild?.remove();
    setTimeout(() => toast.remove(), SHOWN_MS);
  });
}
