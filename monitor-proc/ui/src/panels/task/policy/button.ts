// Opens the editor of the policy, or says why there is none.
import { button } from "../../button";
import type { Desk } from "../../desk";
import { type PolicyFile, readPolicy } from "./api";
import { openPolicy } from "./dialog";

export function policyButton(desk: Desk): HTMLElement {
  /** Why this policy cannot be edited, once it is known. */
  let none: string | null = null;
  const read = async (): Promise<PolicyFile | null> => {
    const file = await readPolicy();
    none = typeof file === "string" ? file : null;
    return typeof file === "string" ? null : file;
  };
  const node = button(desk, {
    label: "Edit policy",
    class: "small",
    about: () => "Edit the file that the policy is written in",
    twin: () => null,
    why: () => desk.refusal() ?? none,
    run: async () => {
      const file = await read();
      if (file === null) desk.say(`not now: ${none ?? ""}`);
      else await openPolicy(desk, file);
    },
  });
  // Asked for before it is pressed, so that the reason is there on hover.
  for (const event of ["pointerenter", "focus"]) {
    node.addEventListener(event, () => {
      if (desk.refusal() === null) void read();
    });
  }
  // Another policy may be a file.
  const forget = () => {
    none = null;
  };
  desk.store.on("graphs", forget);
  desk.store.on("hello", forget);
  return node;
}
