// A small sheet under a button; Escape and a click elsewhere close it.
import { setAttr } from "./dom";

export function popover(opener: HTMLElement, sheet: HTMLElement): { close: () => void } {
  sheet.classList.add("popover");
  sheet.hidden = true;
  setAttr(opener, "aria-haspopup", "true");
  const show = (open: boolean) => {
    sheet.hidden = !open;
    setAttr(opener, "aria-expanded", String(open));
  };
  show(false);
  opener.addEventListener("click", () => {
    show(Boolean(sheet.hidden));
    if (!sheet.hidden) sheet.querySelector<HTMLElement>("input, button")?.focus();
  });
  document.addEventListener("pointerdown", (event) => {
    const inside = event.composedPath();
    if (!inside.includes(sheet) && !inside.includes(opener)) show(false);
  });
  sheet.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    show(false);
    opener.focus();
  });
  return { close: () => show(false) };
}
