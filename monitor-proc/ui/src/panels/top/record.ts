// The record dot: whether a file is written, and what the ring holds.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setAttr, setTitle } from "../dom";
import { bytes } from "../format";
import { popover } from "../popover";

export function recordBadge(desk: Desk): HTMLElement {
  const { store } = desk;
  const writing = () => desk.flag(FLAG.recording) || Boolean(store.status?.recorder.file);
  const why = () => desk.cellRefusal();
  const order = async (what: "start" | "stop" | "last", seconds?: number) => {
    const ack = await store.command({ do: "record", what, ...(seconds === undefined ? {} : { seconds }) });
    if (ack.ok) desk.say(ack.message || "done");
  };
  const dot = button(desk, {
    icon: "dot",
    label: "REC",
    class: "record",
    about: () => `${writing() ? "Stop keeping" : "Keep"} everything in a file. ${ring(desk)}`,
    twin: () => (writing() ? "robocell record stop" : "robocell record start"),
    why,
    run: () => order(writing() ? "stop" : "start"),
  });
  const more = el("button", { type: "button", class: "button caret", "aria-label": "More of the recorder" });
  more.textContent = "▾";
  const sheet = el("div", { class: "menu" });
  const menu = popover(more, sheet);
  for (const span of [10, 60, 300]) {
    sheet.append(
      button(desk, {
        label: `Keep the last ${span} s`,
        about: () => `Copy the last ${span} s of the flight recorder into a file`,
        twin: () => `robocell record last ${span}s`,
        why,
        run: () => {
          menu.close();
          return order("last", span);
        },
      }),
    );
  }
  const note = el("p", { class: "dim" });
  sheet.append(note);
  desk.pulse.add(dot, () => {
    const recorder = store.status?.recorder;
    const tone = recorder?.state === "trouble" ? "warn" : writing() ? "bad" : null;
    setAttr(dot, "data-tone", tone);
    setAttr(dot, "aria-pressed", String(writing()));
    note.textContent = ring(desk);
    setTitle(more, ring(desk));
  });
  return el("span", { class: "with-popover" }, dot, more, sheet);
}

function ring(desk: Desk): string {
  const recorder = desk.store.status?.recorder;
  if (!recorder) return "The recorder has said nothing yet.";
  const full = `${bytes(recorder.bytes)} of ${bytes(recorder.limit_bytes)}`;
  const parts = [`Flight recorder ${recorder.state}: ${full}.`];
  if (recorder.file !== null) parts.push(`Writing ${recorder.file}.`);
  if (recorder.gaps > 0) parts.push(`${recorder.gaps} gaps.`);
  if (recorder.note !== "") parts.push(recorder.note);
  return parts.join(" ");
}
