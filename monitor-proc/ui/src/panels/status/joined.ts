// Text whose lines may end with the separator of its parts, and do not begin with one.
import { el } from "../dom";

/** Sets the text where it is another one. The word before each separator stays with it. */
export function setJoined(node: HTMLElement, text: string): void {
  if (node.textContent === text) return;
  const parts = text.split(/(\S+ ·)(?= )/);
  node.replaceChildren(...parts.map((part) => (part.endsWith(" ·") ? el("span", { class: "joined" }, part) : part)));
}
