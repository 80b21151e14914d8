// The task: its outcome, its buttons, its graph, values and events.
import type { PanelContext } from "../context";
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

export function taskTab(context: PanelContext): HTMLElement {
  const choice = new GraphChoice(context);
  const detail = new NodeDetail(context, () => choice.index);
  choice.on(() => detail.hide());
  const show = (node: number) => {
    choice.keep();
    detail.show(node);
  };
  return el(
    "div",
    { class: "task-tab column" },
    taskSummary(context),
    taskButtons(context),
    breakBanner(context),
    choice.root,
    graphPane(context, choice, show),
    detail.root,
    breakList(context),
    panes([
      ["Events", eventLog(context)],
      ["Values", valueTables(context, choice)],
    ]),
    editLine(context, choice),
  );
}
