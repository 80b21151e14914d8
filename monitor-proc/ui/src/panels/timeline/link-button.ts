// A link to the moment that is shown.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { PanelContext } from "../context";

/** The page's address with the moment that is shown, and nothing secret. */
function linkOf(context: PanelContext): string {
  const link = new URL(location.href);
  link.search = "";
  const keys = new URLSearchParams(link.hash.slice(1));
  const epoch = context.store.past?.epoch;
  keys.set("t", `${(context.snapshot?.time ?? 0).toFixed(3)}${epoch == null ? "" : `@${epoch}`}`);
  link.hash = keys.toString();
  return link.toString();
}

export function linkButton(context: PanelContext): HTMLElement {
  return button(context, {
    icon: "link",
    class: "icon-only quiet",
    about: () =>
      context.flag(FLAG.notLive) ? "Copy a link to this moment" : "Copy a link to now, for when it is past",
    twin: () => null,
    run: async () => {
      const link = linkOf(context);
      try {
        await navigator.clipboard.writeText(link);
        context.notify(`Copied ${link}`);
      } catch {
        context.notify(link);
      }
    },
  });
}
