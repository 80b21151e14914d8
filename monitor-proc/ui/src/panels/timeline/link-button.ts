// A link to the moment that is shown.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { Desk } from "../desk";

/** The page's address with the moment that is shown, and nothing secret. */
function linkOf(desk: Desk): string {
  const link = new URL(location.href);
  link.search = "";
  const keys = new URLSearchParams(link.hash.slice(1));
  const epoch = desk.store.past?.epoch;
  keys.set("t", `${(desk.snapshot?.time ?? 0).toFixed(3)}${epoch == null ? "" : `@${epoch}`}`);
  link.hash = keys.toString();
  return link.toString();
}

export function linkButton(desk: Desk): HTMLElement {
  return button(desk, {
    icon: "link",
    class: "icon-only quiet",
    about: () => (desk.flag(FLAG.notLive) ? "Copy a link to this moment" : "Copy a link to now, for when it is past"),
    twin: () => null,
    run: async () => {
      const link = linkOf(desk);
      const copied = await navigator.clipboard?.writeText(link).then(() => true, () => false);
      desk.say(copied === true ? `Copied ${link}` : link);
    },
  });
}
