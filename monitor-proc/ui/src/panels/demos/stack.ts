// The stack as it should become, and how far it is.
import type { PanelContext } from "../context";
import { el, setAttr, setText, spacer } from "../dom";
import { css } from "../format";

export function mountStack({ store }: PanelContext, element: HTMLElement): () => void {
  const order = names(store.scene?.task.order);
  const place = store.scene?.task.stack_position_m;
  const rows = order.map((name, layer) => {
    const object = store.scene?.objects.find((one) => one.name === name);
    const swatch = el("i", { class: "cube" });
    if (object !== undefined) swatch.style.background = css(object.colour);
    const state = el("span", { class: "dim" });
    const node = el("li", {}, swatch, el("b", {}, name), spacer(), state);
    return { name, layer, state, node };
  });
  const count = el("b", {});
  const where = Array.isArray(place) ? ` at ${place.join(", ")} m` : "";
  element.append(
    el("p", {}, count, ` of ${order.length} cubes are stacked${where}`),
    // The top of the stack is on top.
    el("ol", { class: "stack-order", reversed: true }, ...rows.map(({ node }) => node).reverse()),
  );
  const show = () => {
    const placed = new Set(store.status?.task.placed ?? []);
    const arm = store.snapshot?.arms[0];
    const held = arm?.held == null ? undefined : store.scene?.objects[arm.held]?.name;
    const next = order.find((name) => !placed.has(name));
    setText(count, String(order.filter((name) => placed.has(name)).length));
    for (const { name, state, node } of rows) {
      const now = held === name ? "in the gripper" : placed.has(name) ? "done" : name === next ? "next" : "waits";
      setText(state, now === "done" ? "✓ done" : now);
      setAttr(node, "data-state", now === "in the gripper" ? "held" : now);
    }
  };
  show();
  return store.on("status", show);
}

/** A list of names in a cell file's task, or nothing. */
export function names(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((one): one is string => typeof one === "string") : [];
}
