// What became of a bin or parts that were asked for: a toast, and a line of the events.
import type { Command } from "../../net/protocol";
import type { PanelContext } from "../context";
import { binsOf } from "./bin-state";

/** The monitor tells of equipment four times a second (ms). */
const PATIENCE_MS = 4000;

export async function addBin(context: PanelContext, flipped: boolean): Promise<void> {
  const names = () => {
    const here = binsOf(context.store).filter(({ place }) => place !== "to come" && place !== "not used");
    return new Set(here.map(({ name }) => name));
  };
  const before = names();
  if (!(await ask(context, { do: "add_bin", flipped }, "No bin was added"))) return;
  const added = await wait(context, () => [...names()].find((name) => !before.has(name)) ?? null);
  tell(context, `Added ${added ?? "a bin"}, ${flipped ? "upside down" : "upright"}`);
}

export async function dropParts(context: PanelContext): Promise<void> {
  const equipment = () => context.store.status?.equipment;
  const before = equipment()?.parts_dropped ?? 0;
  if (!(await ask(context, { do: "drop_parts", count: 0 }, "No part was dropped"))) return;
  const wanted = context.store.scene?.dispenser?.per_drop ?? 1;
  const dropped = await wait(context, () => {
    const count = (equipment()?.parts_dropped ?? 0) - before;
    return count >= wanted ? count : null;
  });
  const count = dropped ?? wanted;
  const now = dropped === null ? "will be dropped when time runs" : `${equipment()?.parts_waiting ?? 0} waiting`;
  tell(context, `${dropped === null ? "Asked for" : "Dropped"} ${count} ${count === 1 ? "part" : "parts"}, ${now}`);
}

/** Sends a command; a refusal is told with its reason. */
async function ask(context: PanelContext, command: Command, refused: string): Promise<boolean> {
  const { ok, message } = await context.store.send(command);
  if (!ok) tell(context, `${refused}: ${message}`, true);
  return ok;
}

/** What `find` finds once something is said of the equipment; null after a while. */
function wait<T>(context: PanelContext, find: () => T | null): Promise<T | null> {
  return new Promise((resolve) => {
    const end = (found: T | null) => {
      off();
      clearTimeout(timer);
      resolve(found);
    };
    const off = context.store.on("status", () => {
      const found = find();
      if (found !== null) end(found);
    });
    const timer = setTimeout(() => end(null), PATIENCE_MS);
  });
}

function tell(context: PanelContext, text: string, bad = false): void {
  context.notify(text, bad);
  const time_s = context.snapshot?.time ?? 0;
  const epoch = context.store.timeline?.epochs.at(-1)?.epoch ?? null;
  context.store.takeText({ t: "log", lines: [{ time_s, kind: "log", text: `[page] ${text}`, mark: null, epoch }] });
}
