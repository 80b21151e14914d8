// Opens the editor of the policy, or says why there is none.
import { button } from "../../button";
import type { PanelContext } from "../../context";
import { type PolicyFile, readPolicy } from "./api";
import { openPolicy } from "./dialog";

export function policyButton(context: PanelContext): HTMLElement {
  /** Why this policy cannot be edited, once it is known. */
  let none: string | null = null;
  const read = async (): Promise<PolicyFile | null> => {
    const file = await readPolicy();
    none = typeof file === "string" ? file : null;
    return typeof file === "string" ? null : file;
  };
  const recorded = () => (context.store.hello?.live === false ? "the policy of a recording cannot be edited" : null);
  const node = button(context, {
    label: "Edit policy",
    class: "small",
    about: () => "Edit the file that the policy is written in",
    twin: () => null,
    why: () => context.refusal() ?? recorded() ?? none,
    run: async () => {
      const file = await read();
      if (file === null) context.notify(`not now: ${none ?? ""}`);
      else await openPolicy(context, file);
    },
  });
  // Asked for before it is pressed, so that the reason is there on hover.
  for (const event of ["pointerenter", "focus"]) {
    node.addEventListener(event, () => {
      if (context.refusal() === null && recorded() === null) void read();
    });
  }
  // Another policy may be a file.
  const forget = () => {
    none = null;
  };
  context.store.on("graphs", forget);
  context.store.on("hello", forget);
  return node;
}
