// Commands to copy.
import type { PanelContext } from "../context";
import { el, plainButton } from "../dom";

/** `command` as it is typed for the cell that is shown, and a button that copies it. */
export function copyable(context: PanelContext, command: string): HTMLElement {
  const text = context.onCell(command);
  const isFlag = (word: string) => /^ ?-|^ ?[\w-]+-\w+$/.test(word);
  const words = text.split(/(?= )/).map((word) => (isFlag(word) ? el("span", { class: "flag" }, word) : word));
  const code = el("code", {}, ...words);
  const run = async (event: MouseEvent) => {
    // After a mouse's click, Space is play and pause again.
    if (event.detail > 0) copy.blur();
    context.notify((await copied(text, code)) ? `copied: ${text}` : "press Ctrl+C to copy the marked text");
  };
  const attrs = { class: "button small", "aria-label": `Copy ${text}`, title: "Copy this command" };
  const copy = plainButton(attrs, run, "Copy");
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
