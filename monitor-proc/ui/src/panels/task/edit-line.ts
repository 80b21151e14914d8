// How the policy is changed: in the editor of the page, or on disk and by a restart.
import { button } from "../button";
import type { Desk } from "../desk";
import { el } from "../dom";
import type { GraphChoice } from "./choice";
import { policyButton } from "./policy/button";

export function editLine(desk: Desk, choice: GraphChoice): HTMLElement {
  const restart = button(desk, {
    label: "Restart task",
    class: "small",
    about: () => "Restart the task with its policy file as it is on disk now",
    twin: () => "robocell restart task",
    why: () => desk.cellRefusal(),
    run: () => desk.send({ do: "restart", process: "task" }),
  });
  const about = el("span", {});
  const tell = () => {
    const kind = choice.graph?.kind ?? "";
    const schema = kind === "tree" ? "tree" : "machine";
    const twin = el("code", { title: "Prints the schema of the file, for another editor" }, `robocell schema ${schema}`);
    about.replaceChildren(kind === "code" ? "This policy is code." : twin);
  };
  choice.on(tell);
  tell();
  return el("div", { class: "edit-line dim" }, about, el("span", { class: "spacer" }), policyButton(desk), restart);
}
