// The left side: processes, the view's overlays, the scene.
import type { PanelContext } from "../context";
import { el } from "../dom";
import { inspector } from "../inspect/index";
import { processes } from "./processes";
import { lostList, sceneTree } from "./scene-tree";
import { viewTools } from "./view-tools";

export function mountLeft(context: PanelContext, host: HTMLElement): void {
  const section = (name: string, body: HTMLElement) =>
    el("details", { open: true, class: "section" }, el("summary", {}, name), body);
  host.replaceChildren(
    el(
      "div",
      { class: "scroll" },
      lostList(context),
      section("Processes", processes(context)),
      section("View", viewTools(context)),
      section("Scene", sceneTree(context)),
    ),
    inspector(context),
  );
}
