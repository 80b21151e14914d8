// The tab of the demo that is shown, if it has a panel.
import type { Desk } from "./desk";
import { DEMO_PANELS } from "./demos/index";
import { el } from "./dom";
import type { Tabs } from "./tabs";

const KEY = "demo";

export function demoTab(desk: Desk, tabs: Tabs): void {
  let leave: (() => void) | undefined;
  const show = () => {
    leave?.();
    leave = undefined;
    const panel = DEMO_PANELS[desk.store.scene?.panel ?? ""];
    if (panel === undefined) {
      tabs.remove(KEY);
      return;
    }
    const body = el("div", { class: "demo-tab column scroll" });
    leave = panel.mount(desk, body);
    tabs.put({ key: KEY, name: panel.name, body });
  };
  desk.store.on("scene", show);
  if (desk.store.scene !== null) show();
}
