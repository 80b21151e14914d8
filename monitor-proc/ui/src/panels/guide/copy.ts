// Commands to copy.
import type { PanelContext } from "../context";
import { el } from "../dom";

/** `command` as it is typed for the cell that is shown, and a button that copies it. */
export function copyable(context: PanelContext, command: string): HTMLElement {
  const text = context.onCell(command);
  const words = text.split(/(?= )/).map((word) => (/^ ?-|^ ?[\w-]+-\w+$/.test(word) ? el("span", { class: "flag" }, word) : word));
  const code = el("code", {}, ...words);
  const copy = el("button", { type: "button", class: "button small", "aria-label": `Copy ${text}`, title: "Copy this command" }, "Copy");
  copy.addEventListener("click", (event) => {
    // After a mouse's click, Space is play and pause again.
    if (event.detail > 0) copy.blur();
    void copied(text, code).then((done) => context.notify(done ? `copied: ${text}` : "press Ctrl+C to copy the marked text"));
  });
  return el("div", { class: "copyable" }, code, copy);
}

/** Without the right to write the clipboard the text is marked for Ctrl+C. */
async function copied(text: string, shown: HTMLElement): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    getSelection()?.selectAllChildren(shown);
    return false;
  }
}
