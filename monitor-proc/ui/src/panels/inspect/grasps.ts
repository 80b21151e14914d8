// The grasps of an object by each arm, on request: a search takes up to seconds.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el } from "../dom";
import { list, type ReadPose } from "./rows";

interface Candidate {
  approach: string;
  depth: string;
  tcp: { position: number[] };
  yaw_rad: number;
  width_m: number;
  excluded: string | null;
  why: string | null;
}

interface Grasps {
  candidates: Candidate[];
  reason: string | null;
  message: string | null;
}

const DEG = 180 / Math.PI;

/** A button and the list that it fills. */
export function graspList(context: PanelContext, name: string, index: number, read: ReadPose): HTMLElement[] {
  const found = el("div", { class: "grasps", "aria-live": "polite" });
  let searches = false;
  const why = () => {
    if (searches) return "it searches";
    if (context.store.hello?.live !== true) return "only a live cell has grasps";
    return read() === undefined ? `${name} is not in the scene` : null;
  };
  const search = button(context, {
    label: "Grasps",
    class: "small",
    about: () => `List how each arm can grip ${name} now, and what excludes the other candidates`,
    twin: () => `robocell grasp ${name}`,
    why,
    run: async () => {
      searches = true;
      const broken = el("p", { class: "dim" }, "the answer is broken");
      await fill(context, index, found).catch(() => found.replaceChildren(broken));
      searches = false;
    },
  });
  return [search, found];
}

/** One arm after the other: the monitor does one search at a time. */
async function fill(context: PanelContext, object: number, found: HTMLElement): Promise<void> {
  found.replaceChildren(el("p", { class: "dim" }, "searching …"));
  const lists: HTMLElement[] = [];
  for (const arm of context.store.scene?.arms.keys() ?? []) {
    const answer = await fetch(`/api/grasps/${arm}/${object}`).catch(() => null);
    const head = el("h4", {}, context.armName(arm));
    if (answer?.ok !== true) {
      const refusal = answer === null ? "the monitor does not answer" : await answer.text();
      lists.push(head, el("p", { class: "dim" }, refusal.trim()));
      continue;
    }
    const { candidates, reason, message } = (await answer.json()) as Grasps;
    if (reason !== null) lists.push(head, el("p", { class: "amber" }, `no grasp (${reason}): ${message ?? ""}`));
    else lists.push(head);
    lists.push(el("ol", {}, ...candidates.map(candidateRow)));
  }
  found.replaceChildren(...lists);
}

function candidateRow(of: Candidate, index: number): HTMLElement {
  const isChosen = index === 0 && of.excluded === null;
  const yaw = (of.yaw_rad * DEG).toFixed(0);
  const what = `${of.approach}, ${of.depth}, ${list(of.tcp.position, 3)} m, yaw ${yaw}°, width ${(of.width_m * 1e3).toFixed(1)} mm`;
  const why = of.why ?? (isChosen ? "chosen" : "");
  return el("li", { class: of.excluded === null ? "" : "dim" }, what, why === "" ? "" : el("b", {}, ` ${why}`));
}
