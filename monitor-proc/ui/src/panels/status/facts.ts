// What the bar above the 3D view, and the badge of the task, are told from.
import { afterDone, phaseOf } from "../../net/phases";
import { FLAG, isUnreachable } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { pausedWhy } from "../top/index";
import type { Facts } from "./words";

export function factsOf(context: PanelContext): Facts {
  const { store, snapshot } = context;
  const { hello, status, scene } = store;
  const arms = scene?.arms ?? [];
  const held = (snapshot?.arms ?? []).flatMap(({ held }, arm) => {
    const name = held === null ? undefined : scene?.objects[held]?.name;
    if (name === undefined) return [];
    return [arms.length > 1 ? `${arms[arm]?.name ?? ""} holds ${name}` : `holds ${name}`];
  });
  const shown_s = snapshot?.time ?? 0;
  return {
    link: context.link,
    hello,
    heard_ms: store.heard_ms,
    task: status?.task ?? null,
    phase: phaseOf(store),
    since: afterDone(store),
    shown_s,
    newest_s: Math.max(store.timeline?.to_s ?? 0, shown_s),
    past: context.flag(FLAG.notLive),
    earlierSeed: store.earlier?.seed ?? null,
    paused: context.paused,
    pauseCause: pausedWhy(context),
    taskPaused: context.flag(FLAG.taskPaused),
    startEvent: scene?.start_event === true,
    held,
    unreached: unreached(context),
    lost: store.lost,
    fallen: store.fallen,
    incidents: new Set(store.marked.flatMap(({ incident }) => incident ?? [])).size,
  };
}

/** Of a task that only follows a person's target: a job knows what to do about it. */
function unreached({ snapshot, store: { scene } }: PanelContext): string {
  if (scene?.task["kind"] !== "reach") return "";
  const arm = snapshot?.arms.find(isUnreachable);
  return arm === undefined ? "" : `${(1000 * arm.positionError).toFixed(0)} mm away: ${arm.notReached ?? "unreachable"}`;
}
