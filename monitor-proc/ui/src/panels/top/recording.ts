// The record dot: whether a file is written, and what the ring holds.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setTitle } from "../dom";
import { bytes } from "../format";
import { popover } from "../popover";

export function recordingBadge(context: PanelContext): HTMLElement {
  const { store } = context;
  // A cell that has ended writes nothing.
  const writing = () => !context.isStale && (context.flag(FLAG.recording) || Boolean(store.status?.recorder.file));
  const why = () => context.cellRefusal();
  const order = async (what: "start" | "stop" | "last", seconds?: number) => {
    const ack = await store.command({ do: "record", what, ...(seconds === undefined ? {} : { seconds }) });
    if (ack.ok) context.notify(ack.message || "done");
  };
  const dot = button(context, {
    icon: "dot",
    label: "REC",
    class: "record",
    about: () => `${writing() ? "Stop keeping" : "Keep"} everything in a file. ${ring(context)}`,
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
      button(context, {
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
  context.pulse.add(dot, () => {
    const recorder = store.status?.recorder;
    const tone = context.isStale ? null : recorder?.state === "trouble" ? "warn" : writing() ? "bad" : null;
    setAttr(dot, "data-tone", tone);
    setAttr(dot, "aria-pressed", String(writing()));
    note.textContent = ring(context);
    setTitle(more, ring(context));
  });
  return el("span", { class: "with-popover" }, dot, more, sheet);
}

function ring(context: PanelContext): string {
  const recorder = context.store.status?.recorder;
  if (!recorder) return "The recorder has said nothing yet.";
  const full = `${bytes(recorder.bytes)} of ${bytes(recorder.limit_bytes)}`;
  const parts = [`Flight recorder ${recorder.state}: ${full}.`];
  if (recorder.file !== null) parts.push(`Writing ${recorder.file}.`);
  if (recorder.gaps > 0) parts.push(`${recorder.gaps} gaps.`);
  if (recorder.note !== "") parts.push(recorder.note);
  return parts.join(" ");
}
