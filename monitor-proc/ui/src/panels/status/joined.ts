// Text whose lines may end with the separator of its parts, and do not begin with one; a number and its unit share a line.
import { el } from "../dom";

/** A number with the word after it, and a word with the separator after it. */
const TOGETHER = /(\d[\d.]* [^\s·]\S*(?: ·)?(?= |$)|\S+ ·(?= ))/;

/** Sets the text where it is another one. */
export function setJoined(node: HTMLElement, text: string): void {
  if (node.textContent === text) return;
  const parts = text.split(TOGETHER);
  node.replaceChildren(...parts.map((part, index) => (index % 2 === 1 ? el("span", { class: "joined" }, part) : part)));
}
