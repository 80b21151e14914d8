// Making and changing elements. Text goes in as text only: names come from
// files and may hold anything.

type Attrs = Record<string, string | number | boolean>;
type Child = Node | string | null;

function fill<E extends Element>(element: E, attrs: Attrs, children: Child[]): E {
  for (const [name, value] of Object.entries(attrs)) {
    if (value !== false) element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attrs: Attrs = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  return fill(document.createElement(tag), attrs, children);
}

export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attrs: Attrs = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attrs, children);
}

/** A button that calls `run` and can always be pressed. Its class is `button` where `attrs` has no other. */
export function plainButton(
  attrs: Attrs,
  run: (event: MouseEvent) => unknown,
  ...children: Child[]
): HTMLButtonElement {
  const node = el("button", { type: "button", class: "button", ...attrs }, ...children);
  node.addEventListener("click", run);
  return node;
}

/** Takes the room that is left in a row. */
export function spacer(): HTMLElement {
  return el("span", { class: "spacer" });
}

/** A dialog whose header has `head` and a button that closes it; a click beside it closes it, too. */
export function sheet(attrs: Attrs, head: Child[], ...body: Child[]): HTMLDialogElement {
  const close = plainButton({}, () => dialog.close(), "Close");
  const dialog = el("dialog", attrs, el("header", {}, ...head, close), ...body);
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  document.body.append(dialog);
  return dialog;
}

/** Sets the text where it is another one: untouched nodes cost no layout. */
export function setText(node: Node, text: string): void {
  const only = node.firstChild;
  // To read the text of an element makes a string of all that is in it.
  if (only?.nodeType === Node.TEXT_NODE && only.nextSibling === null && text !== "") {
    if ((only as Text).data !== text) (only as Text).data = text;
  } else if (node.textContent !== text) node.textContent = text;
}

export function setTitle(node: HTMLElement, text: string): void {
  if (node.title !== text) node.title = text;
}

/** Sets or (null) removes an attribute, where it differs. */
export function setAttr(node: Element, name: string, value: string | null): void {
  if (node.getAttribute(name) === value) return;
  if (value === null) node.removeAttribute(name);
  else node.setAttribute(name, value);
}

/** A select with `values`, keeping the choice where it still exists. */
export function setOptions(select: HTMLSelectElement, values: string[], chosen?: string): void {
  const before = chosen ?? select.value;
  const same =
    select.options.length === values.length && values.every((value, index) => select.options[index]?.value === value);
  if (!same) {
    select.replaceChildren(...values.map((value) => el("option", { value }, value)));
  }
  if (values.includes(before)) select.value = before;
}

/** Scrolls `box`, and nothing around it, so that `node` is well inside. */
export function reveal(box: Element | null, node: Element | undefined): void {
  if (box === null || node === undefined) return;
  const [outer, inner] = [box.getBoundingClientRect(), node.getBoundingClientRect()];
  const margin = Math.min(outer.height / 4, 60);
  if (inner.top < outer.top + margin || inner.bottom > outer.bottom - margin) {
    // Rows above it are whole.
    const above = Math.floor((outer.height - inner.height) / 2 / Math.max(inner.height, 1));
    box.scrollTop += inner.top - outer.top - Math.max(above, 0) * inner.height;
  }
  if (inner.left < outer.left || inner.right > outer.right) {
    box.scrollLeft += (inner.left + inner.right - outer.left - outer.right) / 2;
  }
}
