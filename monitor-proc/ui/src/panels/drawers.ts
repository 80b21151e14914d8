// In a narrow window the sides are drawers over the 3D view, which keeps all of the
// width; one is open at a time.
import { el, setAttr } from "./dom";

const SIDES = [
  { name: "left", label: "Cell", about: "Processes, view and scene" },
  { name: "right", label: "Panels", about: "Task, robot, plots and latency" },
] as const;

/** Buttons that open the drawers; the style sheet shows them where there are any. */
export function drawerButtons(): HTMLElement {
  const buttons = SIDES.map(({ name, label, about }) => {
    const node = el("button", { type: "button", class: "button", title: about, "aria-controls": name }, label);
    node.addEventListener("click", () => open(isOpen(name) ? null : name));
    return node;
  });
  const isOpen = (name: string) => document.body.classList.contains(`show-${name}`);
  const open = (wanted: string | null) => {
    for (const [index, { name }] of SIDES.entries()) {
      document.body.classList.toggle(`show-${name}`, name === wanted);
      const node = buttons[index];
      if (node !== undefined) setAttr(node, "aria-expanded", String(name === wanted));
    }
  };
  open(null);
  document.getElementById("view")?.addEventListener("pointerdown", () => open(null));
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") open(null);
  });
  return el("div", { class: "group drawer-buttons", role: "group", "aria-label": "Drawers" }, ...buttons);
}
