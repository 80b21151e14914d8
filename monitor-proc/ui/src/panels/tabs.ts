// Tabs of the right side; the URL's hash keeps which one is open.
import { el, plainButton, setAttr } from "./dom";
import { getHash, setHash } from "./hash";

export interface Tab {
  key: string;
  name: string;
  body: HTMLElement;
}

export interface Tabs {
  root: HTMLElement;
  /** Puts `tab` in the place of the one with its key, or behind the others. */
  put: (tab: Tab) => void;
  remove: (key: string) => void;
  open: (key: string) => void;
}

export function tabs(first: Tab[]): Tabs {
  const bar = el("div", { class: "tab-bar", role: "tablist", "aria-label": "Panels" });
  const body = el("div", { class: "tab-body" });
  const all = new Map<string, { button: HTMLElement; panel: HTMLElement }>();
  const fallback = first[0]?.key ?? "";

  const open = (wanted: string) => {
    const key = all.has(wanted) ? wanted : fallback;
    for (const [name, { button, panel }] of all) {
      const on = name === key;
      setAttr(button, "aria-selected", String(on));
      button.tabIndex = on ? 0 : -1;
      panel.hidden = !on;
    }
  };
  const choose = (key: string) => {
    setHash("tab", key === fallback ? null : key);
    open(key);
  };
  const remove = (key: string) => {
    const old = all.get(key);
    old?.button.remove();
    old?.panel.remove();
    all.delete(key);
    open(getHash("tab") ?? fallback);
  };
  const put = (tab: Tab) => {
    remove(tab.key);
    const button = plainButton({ class: false, role: "tab", id: `tab-${tab.key}` }, () => choose(tab.key), tab.name);
    const attrs = { role: "tabpanel", class: "tab-panel", "aria-labelledby": button.id };
    const panel = el("div", attrs, tab.body);
    bar.append(button);
    body.append(panel);
    all.set(tab.key, { button, panel });
    open(getHash("tab") ?? fallback);
  };
  bar.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step === undefined) return;
    const keys = [...all.keys()];
    const now = keys.findIndex((key) => all.get(key)?.button === document.activeElement);
    const next = keys[(now + step + keys.length) % keys.length];
    if (next === undefined) return;
    choose(next);
    all.get(next)?.button.focus();
  });
  addEventListener("hashchange", () => open(getHash("tab") ?? fallback));
  for (const tab of first) put(tab);
  return { root: el("div", { class: "tabs" }, bar, body), put, remove, open: choose };
}

/** Two or more panes in one place; on high screens CSS shows them all. */
export function panes(entries: [string, HTMLElement][]): HTMLElement {
  const bar = el("div", { class: "pane-bar segments", role: "group", "aria-label": "Panes" });
  const root = el("div", { class: "panes" }, bar);
  const buttons = entries.map(([name, body], index) => {
    const button = plainButton({ class: "button small" }, () => open(index), name);
    const pane = el("section", { class: "pane", "aria-label": name }, el("h3", {}, name), body);
    bar.append(button);
    root.append(pane);
    return { button, pane };
  });
  const open = (chosen: number) => {
    for (const [index, { button, pane }] of buttons.entries()) {
      setAttr(button, "aria-pressed", String(index === chosen));
      pane.classList.toggle("active", index === chosen);
    }
  };
  open(0);
  return root;
}
