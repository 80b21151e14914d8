// What became of a bin or parts that were asked for: a toast, and a line of the events.
import type { Desk } from "../desk";
import { binsOf } from "./bin-state";

/** The monitor tells of equipment four times a second (ms). */
const PATIENCE_MS = 4000;

export async function addBin(desk: Desk, flipped: boolean): Promise<void> {
  const names = () => new Set(binsOf(desk.store).filter(({ place }) => place !== "to come").map(({ name }) => name));
  const before = names();
  if (!(await ask(desk, { do: "add_bin", flipped }, "No bin was added"))) return;
  const added = await wait(desk, () => [...names()].find((name) => !before.has(name)) ?? null);
  tell(desk, `Added ${added ?? "a bin"}, ${flipped ? "upside down" : "upright"}`);
}

export async function dropParts(desk: Desk): Promise<void> {
  const equipment = () => desk.store.status?.equipment;
  const before = equipment()?.parts_dropped ?? 0;
  if (!(await ask(desk, { do: "drop_parts", count: 0 }, "No part was dropped"))) return;
  const wanted = desk.store.scene?.dispenser?.per_drop ?? 1;
  const dropped = await wait(desk, () => {
    const count = (equipment()?.parts_dropped ?? 0) - before;
    return count >= wanted ? count : null;
  });
  const count = dropped ?? wanted;
  const now = dropped === null ? "will be dropped when time runs" : `${equipment()?.parts_waiting ?? 0} waiting`;
  tell(desk, `${dropped === null ? "Asked for" : "Dropped"} ${count} ${count === 1 ? "part" : "parts"}, ${now}`);
}

/** Sends a command; a refusal is told with its reason. */
async function ask(desk: Desk, command: Parameters<Desk["store"]["send"]>[0], refused: string): Promise<boolean> {
  const { ok, message } = await desk.store.send(command);
  if (!ok) tell(desk, `${refused}: ${message}`, true);
  return ok;
}

/** What `find` finds once something is said of the equipment; null after a while. */
function wait<T>(desk: Desk, find: () => T | null): Promise<T | null> {
  return new Promise((resolve) => {
    const end = (found: T | null) => {
      off();
      clearTimeout(timer);
      resolve(found);
    };
    const off = desk.store.on("status", () => {
      const found = find();
      if (found !== null) end(found);
    });
    const timer = setTimeout(() => end(null), PATIENCE_MS);
  });
}

function tell(desk: Desk, text: string, bad = false): void {
  desk.say(text, bad);
  const time_s = desk.snapshot?.time ?? 0;
  const epoch = desk.store.timeline?.epochs.at(-1)?.epoch ?? null;
  desk.store.takeText({ t: "log", lines: [{ time_s, kind: "log", text: `[page] ${text}`, mark: null, epoch }] });
}
