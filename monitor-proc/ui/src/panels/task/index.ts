// The task: how it stands, its buttons, its graph, values and events.
import { button } from "../button";
import type { Desk } from "../desk";
import { el } from "../dom";
import { panes } from "../tabs";
import { eventLog } from "./events";
import { graphPane } from "./graph-pane";
import { NodeDetail } from "./node-detail";
import { taskButtons } from "./buttons";
import { taskSummary } from "./summary";
import { GraphChoice } from "./choice";
import { valueTables } from "./values";

export function taskTab(desk: Desk): HTMLElement {
  const choice = new GraphChoice(desk.store);
  const detail = new NodeDetail(desk.store, choice);
  return el(
    "div",
    { class: "task-tab column" },
    taskSummary(desk),
    taskButtons(desk),
    choice.root,
    graphPane(desk, choice, (node) => detail.show(node)),
    detail.root,
    panes([
      ["Events", eventLog(desk)],
      ["Values", valueTables(desk.store, choice)],
    ]),
    editLine(desk, choice),
  );
}

function editLine(desk: Desk, choice: GraphChoice): HTMLElement {
  const restart = button(desk, {
    label: "Restart task",
    class: "small",
    about: () => "Begin the task again with its descriptor as it is on disk now",
    twin: () => "robocell restart task",
    why: () => desk.cellRefusal(),
    run: () => desk.send({ do: "restart", process: "task" }),
  });
  const about = el("span", {});
  const tell = () => {
    const kind = choice.graph?.kind ?? "";
    const [form, schema] = kind === "tree" ? ["JSON", "tree"] : ["TOML", "machine"];
    const words = [`Edit descriptors as ${form} in your editor (`, el("code", {}, `robocell schema ${schema}`), "); a restart takes them over."];
    about.replaceChildren(...(kind === "code" ? ["This policy is code; a restart begins it anew."] : words));
  };
  choice.on(tell);
  tell();
  return el("p", { class: "edit-line dim" }, about, restart);
}
