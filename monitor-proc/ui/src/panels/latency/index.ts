// How long each hop takes, and which cycles were missed and why.
import type { HopLatency, ProcessStatus } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, spacer } from "../dom";
import { micros } from "../format";
import { term } from "../terms";
import { histogram } from "./histogram";

export function latencyTab(context: PanelContext): HTMLElement {
  const hops = el("div", { class: "hops" }, el("p", { class: "dim hint" }, "No hop was measured yet."));
  const body = el("tbody", {});
  const missed = el("div", { class: "missed" }, el("table", {}, el("thead", {}, headRow()), body));
  const marks = ["p50", "p99"].flatMap((name) => [el("i", { class: name }), term(name)]);
  const legend = [...marks, "; ", term("p99.9"), "; both axes are in powers of ten"];
  const twins = [el("code", {}, "robocell top"), ", ", el("code", {}, "robocell bench e2e")];
  const root = el(
    "div",
    { class: "latency-tab column scroll of-now", tabindex: 0 },
    el("h3", {}, "Cycles of each process"),
    missed,
    el("h3", {}, term("Hops", "hop")),
    el("p", { class: "dim hop-legend" }, ...legend),
    hops,
    el("p", { class: "dim" }, "The same in the terminal: ", ...twins),
  );
  let stale = true;
  const draw = () => {
    const { status } = context.store;
    if (status === null || !stale) return;
    stale = false;
    if (status.latency.length > 0) hops.replaceChildren(...status.latency.map((hop) => hopRow(context, hop)));
    body.replaceChildren(...cycleRows(status.processes));
  };
  context.store.on("status", () => (stale = true));
  context.pulse.add(root, draw);
  return root;
}

function hopRow(context: PanelContext, hop: HopLatency): HTMLElement {
  const name = hop.arm === null ? hop.hop : `${hop.hop} · ${context.armName(hop.arm)}`;
  const figures = [
    ["p50", hop.p50_us],
    ["p99", hop.p99_us],
    ["p99.9", hop.p999_us],
    ["max", hop.max_us],
  ] as const;
  const head = el("div", { class: "row" }, el("b", {}, name), spacer(), el("span", { class: "dim num" }, `n ${hop.n}`));
  const cells = figures.map(([label, us]) => {
    const value = el("b", { class: "num" }, hop.n > 0 ? micros(us) : "–");
    return el("span", { class: "figure" }, el("span", { class: "dim" }, label), value);
  });
  const bars = hop.n > 0 ? histogram(hop) : null;
  return el("div", { class: "hop" }, head, el("div", { class: "figures" }, ...cells), bars);
}

const HEADS = ["process", "missed", "late p99", "late max", "body p50", "body p99"];

function headRow(): HTMLElement {
  const cell = (name: string) => el("th", { scope: "col" }, ...name.split(" ").flatMap((word) => [term(word), " "]));
  return el("tr", {}, ...HEADS.map(cell));
}

function cycleRows(processes: ProcessStatus[]): HTMLElement[] {
  return processes.flatMap((one) => {
    const times = [one.late_p99_us, one.late_max_us, one.body_p50_us, one.body_p99_us];
    const cells = times.map((us) => el("td", { class: "num" }, us > 0 ? micros(us) : "–"));
    const missed = el("td", { class: one.missed > 0 ? "num amber" : "num" }, String(one.missed));
    const row = el("tr", {}, el("th", { scope: "row" }, one.name), missed, ...cells);
    const notes = [one.missed_why === "" ? "" : `missed: ${one.missed_why}`, one.note].filter((text) => text !== "");
    const noted = notes.map((text) => el("td", { colspan: HEADS.length, class: "dim" }, text));
    return [row, ...noted.map((cell) => el("tr", { class: "note" }, cell))];
  });
}
