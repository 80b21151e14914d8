// The panels around the 3D view.
import "../style.css";
import type { Hand } from "../hand/hand";
import type { Jog } from "../hand/jog";
import type { Store } from "../net/store";
import { actions } from "./actions";
import { PanelContext } from "./context";
import { demoTab } from "./demo-tab";
import { mountGuide } from "./guide/index";
import { helpSheet } from "./help";
import { mountKeys } from "./keys";
import { latencyTab } from "./latency/index";
import { mountLeft } from "./left/index";
import { tellPhasesApart } from "./phase-colour";
import { plotsTab } from "./plots/index";
import { robotTab } from "./robot/index";
import { mountSplitters } from "./splitters";
import { mountStatus } from "./status/index";
import { tabs } from "./tabs";
import { taskTab } from "./task/index";
import { mountTerms } from "./terms";
import { mountTimeline } from "./timeline";
import { mountToasts } from "./toasts";
import { mountTop, stepsInput, stepsOf } from "./top/index";
import type { ViewApi } from "./view-api";

/** Fills #top, #left, #right and #bottom; works without a view and before any data. */
export function mountPanels(store: Store, view: ViewApi | null, hand: Hand, jog: Jog): void {
  tellPhasesApart(store);
  const context = new PanelContext(store, view, hand);
  const steps = stepsInput();
  const act = actions(context, () => stepsOf(steps));
  const help = helpSheet();
  const place = (id: string, fill: (host: HTMLElement) => void) => {
    const host = document.getElementById(id);
    if (host !== null) fill(host);
  };
  place("top", (host) => mountTop(context, host, act, steps, help));
  place("status", (host) => mountStatus(context, host));
  place("left", (host) => mountLeft(context, host));
  place("right", (host) => {
    const all = tabs([
      { key: "task", name: "Task", body: taskTab(context) },
      { key: "robot", name: "Robot", body: robotTab(context, act, jog) },
      { key: "plots", name: "Plots", body: plotsTab(context) },
      { key: "latency", name: "Latency", body: latencyTab(context) },
    ]);
    demoTab(context, all);
    context.openTab = all.open;
    host.replaceChildren(all.root);
  });
  place("bottom", (host) => mountTimeline(context, host));
  mountGuide(context);
  mountSplitters();
  mountToasts(context);
  mountTerms();
  mountKeys(context, act, help);
}
