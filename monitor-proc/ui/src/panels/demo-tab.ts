// The tab of the demo that is shown, if it has a panel.
import type { PanelContext } from "./context";
import { DEMO_PANELS } from "./demos/index";
import { el } from "./dom";
import type { Tabs } from "./tabs";

const KEY = "demo";

export function demoTab(context: PanelContext, tabs: Tabs): void {
  let leave: (() => void) | undefined;
  const show = () => {
    leave?.();
    leave = undefined;
    const panel = DEMO_PANELS[context.store.scene?.panel ?? ""];
    if (panel === undefined) {
      tabs.remove(KEY);
      return;
    }
    const body = el("div", { class: "demo-tab column scroll" });
    leave = panel.mount(context, body);
    tabs.put({ key: KEY, name: panel.name, body });
  };
  context.store.on("scene", show);
  if (context.store.scene !== null) show();
}
