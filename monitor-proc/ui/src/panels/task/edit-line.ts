// How the policy is changed: in the editor of the page, or on disk and by a restart.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, spacer } from "../dom";
import type { GraphChoice } from "./choice";
import { policyButton } from "./policy/button";

export function editLine(context: PanelContext, choice: GraphChoice): HTMLElement {
  const restart = button(context, {
    label: "Restart task",
    class: "small",
    about: () => "Restart the task with its policy file as it is on disk now",
    twin: () => "robocell restart task",
    why: () => context.cellRefusal(),
    run: () => context.send({ do: "restart", process: "task" }),
  });
  const about = el("span", {});
  const tell = () => {
    const kind = choice.graph?.kind ?? "";
    const schema = kind === "tree" ? "tree" : "machine";
    const title = "Prints the schema of the file, for another editor";
    about.replaceChildren(
      kind === "code" ? "This policy is code." : el("code", { title }, `robocell schema ${schema}`),
    );
  };
  choice.on(tell);
  tell();
  return el("div", { class: "edit-line dim" }, about, spacer(), policyButton(context), restart);
}
