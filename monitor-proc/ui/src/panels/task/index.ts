// The task: its outcome, its buttons, its graph, values and events.
import type { Desk } from "../desk";
import { el } from "../dom";
import { panes } from "../tabs";
import { breakBanner, breakList } from "./breaks/bar";
import { taskButtons } from "./buttons";
import { GraphChoice } from "./choice";
import { editLine } from "./edit-line";
import { eventLog } from "./events";
import { graphPane } from "./graph/pane";
import { NodeDetail } from "./node-detail";
import { taskSummary } from "./summary";
import { valueTables } from "./values";

export function taskTab(desk: Desk): HTMLElement {
  const choice = new GraphChoice(desk.store);
  const detail = new NodeDetail(desk, () => choice.index);
  choice.on(() => detail.hide());
  return el(
    "div",
    { class: "task-tab column" },
    taskSummary(desk),
    taskButtons(desk),
    breakBanner(desk),
    choice.root,
    graphPane(desk, choice, (node) => detail.show(node)),
    detail.root,
    breakList(desk),
    panes([
      ["Events", eventLog(desk)],
      ["Values", valueTables(desk, choice)],
    ]),
    editLine(desk, choice),
  );
}
