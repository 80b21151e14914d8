// What the bar above the 3D view, and the badge of the task, are told from.
import { afterDone, isPickingUp, phaseOf } from "../../net/phases";
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
    isPickingUp: held.length === 0 && isPickingUp(store),
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
    target: target(context),
    lost: store.lost,
    // Parts of a dispenser are counted in its panel.
    fallen: scene?.dispenser == null ? store.fallen : [],
    incidents: new Set(store.marked.flatMap(({ incident }) => incident ?? [])).size,
  };
}

/** Of a task that only follows a person's target: a job knows what to do about it. */
function unreached({ snapshot, store: { scene } }: PanelContext): string {
  if (scene?.task.kind !== "reach") return "";
  const arm = snapshot?.arms.find(isUnreachable);
  if (arm === undefined) return "";
  return `${(1000 * arm.positionError).toFixed(0)} mm away: ${arm.notReached ?? "unreachable"}`;
}

/** Nearer than this an arm is at its target, and farther than that it is not (m): between them nothing changes. */
const THERE_M = 0.01;
const LEFT_M = 0.012;
/** Shown distances have steps of so much near the target and far from it (mm). */
const NEAR_STEP_MM = 10;
const FAR_STEP_MM = 50;
const FAR_MM = 200;
/** By page: whether the arm was at its target. */
const there = new WeakMap<PanelContext, boolean>();

/** Where the arm is of a task that only follows a person's target. */
function target(context: PanelContext): string {
  const led = context.snapshot?.arms.filter(({ goalActive, targetValid }) => goalActive && targetValid) ?? [];
  if (context.store.scene?.task.kind !== "reach") return "";
  if (led.length === 0) return "no target";
  const away_m = Math.max(...led.map(({ positionError }) => positionError));
  const isThere = away_m < (there.get(context) === true ? LEFT_M : THERE_M);
  there.set(context, isThere);
  if (isThere) return "at the target";
  const away_mm = 1000 * away_m;
  const step = away_mm > FAR_MM ? FAR_STEP_MM : NEAR_STEP_MM;
  return `${Math.max(step, Math.round(away_mm / step) * step)} mm to the target`;
}
