// In a narrow window the sides are drawers over the 3D view, which keeps all of the
// width; one is open at a time.
import { el, plainButton, setAttr } from "./dom";

const SIDES = [
  { name: "left", label: "Cell", about: "Processes, view and scene" },
  { name: "right", label: "Panels", about: "Task, robot, plots and latency" },
] as const;

const isOpen = (name: string) => document.body.classList.contains(`show-${name}`);

/** Opens one drawer, or closes both. */
export function openDrawer(wanted: "left" | "right" | null): void {
  for (const { name } of SIDES) {
    document.body.classList.toggle(`show-${name}`, name === wanted);
    const node = document.querySelector(`.drawer-buttons [aria-controls=${name}]`);
    if (node !== null) setAttr(node, "aria-expanded", String(name === wanted));
  }
}

/** Buttons that open the drawers; the style sheet shows them where there are any. */
export function drawerButtons(): HTMLElement {
  const buttons = SIDES.map(({ name, label, about }) => {
    const attrs = { title: about, "aria-controls": name, "aria-expanded": "false" };
    return plainButton(attrs, () => openDrawer(isOpen(name) ? null : name), label);
  });
  document.getElementById("view")?.addEventListener("pointerdown", () => openDrawer(null));
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") openDrawer(null);
  });
  return el("div", { class: "group drawer-buttons", role: "group", "aria-label": "Drawers" }, ...buttons);
}
