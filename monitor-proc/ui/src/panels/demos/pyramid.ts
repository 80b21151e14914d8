// The owners of the centre and of each cube, the cubes that each arm has placed,
// and both trees side by side. The data is on the board that the trees share.
import type { Store } from "../../net/store";
import type { PanelContext } from "../context";
import { el, setAttr, setText } from "../dom";
import { css } from "../format";
import { Outline } from "../task/graph/outline";
import { sharedKeys } from "../task/values";

/** The value of key `name` on any shared board. */
function keyed(store: Store, name: string): string | undefined {
  const found = Object.entries(sharedKeys(store)).find(([key]) => key.slice(key.indexOf(".") + 1) === name);
  return found?.[1].replace(/^["']|["']$/g, "");
}

/** The members of a set as it is written: `{0, 1}`, by place in the cell file. */
function members(set: string): string[] {
  return (set.match(/[^\s,{}[\]()"']+/g) ?? []).filter((one) => one !== "unset");
}

export function mountPyramid(context: PanelContext, element: HTMLElement): () => void {
  const { store } = context;
  const scene = store.scene;
  const arms = scene?.arms.map(({ name }) => name) ?? [];
  const owner = el("b", { class: "badge" }, "free");
  const sides = arms.map((name) => {
    const placed = el("div", { class: "placed-set" });
    const state = el("span", { class: "dim" });
    const head = el("div", { class: "row" }, el("b", {}, name), state);
    return { name, placed, state, node: el("div", { class: "side" }, head, placed) };
  });
  const cubes = (scene?.objects ?? []).map(({ name, colour }) => {
    const swatch = el("i", { class: "cube" });
    swatch.style.background = css(colour);
    const state = el("span", { class: "dim" });
    return { name, state, node: el("div", { class: "cube-row" }, swatch, el("span", {}, name), state) };
  });
  const trees = el("div", { class: "side-by-side" });
  element.append(
    el("p", { class: "row" }, "The centre belongs to", owner),
    el("div", { class: "sides" }, ...sides.map(({ node }) => node)),
    el("h3", {}, "Cubes"),
    el("div", { class: "cube-list" }, ...cubes.map(({ node }) => node)),
    el("h3", {}, "Both trees"),
    trees,
  );
  const show = () => {
    const centre = keyed(store, "center_owner") ?? "";
    setText(owner, centre === "" ? "no arm" : centre);
    setAttr(owner, "data-tone", centre === "" ? null : centre === arms[0] ? "info" : "warn");
    for (const { name, state, node } of cubes) {
      const word = keyed(store, `cube_state:${name}`) ?? "available";
      const [what, whose] = word.split(":");
      setText(state, whose === undefined ? (what ?? "") : `${what} by ${whose}`);
      setAttr(node, "data-state", what ?? "");
    }
    for (const { name, placed, state } of sides) {
      const set = keyed(store, `placed:${name}`) ?? "";
      const inSet = members(set).map((one) => scene?.objects[Number(one)]?.name ?? one);
      const required = Number(scene?.task.required_count ?? 3);
      setText(placed, inSet.length === 0 ? "nothing placed yet" : inSet.join(", "));
      const request = keyed(store, `recovery_requested:${name}`) === "true" ? " · recovery asked for" : "";
      setText(state, `${inSet.length} of ${required}${request}`);
    }
  };
  let views: { show: () => void }[] = [];
  const drawTrees = () => {
    const onNode = () => {};
    const drawn = store.graphs.map((graph, at) => new Outline({ context, at, graph, name: "beside", onNode }));
    views = drawn;
    trees.replaceChildren(...drawn.map(({ root }) => el("div", { class: "graph-body" }, root)));
    for (const view of drawn) view.show();
  };
  drawTrees();
  show();
  const offGraphs = store.on("graphs", drawTrees);
  const offGraph = store.on("graph", (index) => {
    views[index]?.show();
    show();
  });
  return () => {
    offGraphs();
    offGraph();
  };
}
