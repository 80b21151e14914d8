// What was kept of a failure: events, the loops' last seconds, the end of logs.
import "uplot/dist/uPlot.min.css";
import type { PanelContext } from "../context";
import { el, plainButton, sheet } from "../dom";
import { lookAt } from "../seek";
import { chart } from "./chart";
import { type Incident, type LoopTrace, summary } from "./summary";

const LISTED = 8;
/** The second after the incident is written by then. */
const COMPLETE_MS = 1500;

async function load(context: PanelContext, number: number): Promise<Incident | null> {
  const answer = await fetch(`/api/incidents/${number}`).catch(() => null);
  if (answer?.ok === true) return (await answer.json()) as Incident;
  context.notify(`incident ${number}: ${answer === null ? "the monitor is away" : await answer.text()}`, true);
  return null;
}

/** Opens the sheet of incident `number`. */
export async function openIncident(context: PanelContext, number: number): Promise<void> {
  const incident = await load(context, number);
  if (incident === null) return;
  const body = el("div", { class: "incident-body scroll", tabindex: 0 });
  const title = el("h2", {}, `Incident ${number}: ${incident.what}`);
  const leave = () => dialog.close();
  const ways = [look(context, incident, leave), ...neighbours(context, number, leave)];
  const dialog = sheet({ class: "incident", "aria-label": `Incident ${number}` }, [title, ...ways], body);
  dialog.addEventListener("close", () => dialog.remove());
  dialog.showModal();
  // Plots need to know how wide they are.
  const show = (shown: Incident) => body.replaceChildren(...content(context, shown, body.clientWidth));
  show(incident);
  if (incident.complete) return;
  setTimeout(() => {
    if (dialog.open) void load(context, number).then((whole) => whole !== null && dialog.open && show(whole));
  }, COMPLETE_MS);
}

/** Shows the moment of the failure in the view. */
function look(context: PanelContext, { number, sim_time_s }: Incident, close: () => void): HTMLElement {
  const run = () => {
    close();
    const epoch = context.store.marked.find((line) => line.incident === number)?.epoch ?? null;
    lookAt(context, { time_s: sim_time_s, epoch });
  };
  return plainButton({ class: "button primary" }, run, "Look at this moment");
}

/** Buttons for the incidents before and after this one. */
function neighbours(context: PanelContext, number: number, close: () => void): HTMLElement[] {
  const known = context.store.marked.flatMap((line) => line.incident ?? []).sort((a, b) => a - b);
  const others = [known.filter((one) => one < number).at(-1), known.find((one) => one > number)];
  return others.flatMap((other) => {
    if (other === undefined) return [];
    const run = () => {
      close();
      void openIncident(context, other);
    };
    return [plainButton({}, run, `Incident ${other}`)];
  });
}

function content(context: PanelContext, incident: Incident, width: number): HTMLElement[] {
  const { number, at, sim_time_s, demo, policy, seed } = incident;
  const facts = `${at}, ${demo} with policy ${policy}, seed ${seed}, ${sim_time_s.toFixed(3)} s of simulated time`;
  const marks = incident.events.map((event) => event.at_ms);
  const arms = (context.store.scene?.arms ?? []).map(({ name }) => name);
  const twin = context.onCell(`robocell incident ${number}`);
  const sentences = summary(incident, context.store.marked, arms).map((sentence) => el("li", {}, sentence));
  const events = incident.events.map((event) => `${event.at_ms.toFixed(1)} ms  ${event.what}`);
  const parts = [
    el("ul", { class: "incident-summary" }, ...sentences),
    el("p", { class: "dim" }, facts),
    el("p", { class: "dim" }, "The same on the command line: ", el("code", {}, twin)),
    list("Events", events),
  ];
  const span: [number, number] = [
    Math.min(-1, ...incident.loops.map((loop) => loop.at_ms[0] ?? 0)),
    Math.max(1, ...incident.loops.map((loop) => loop.at_ms.at(-1) ?? 0)),
  ];
  for (const loop of incident.loops) parts.push(loopPart(loop, { width, span, marks }));
  for (const log of incident.logs) {
    const lines = log.lines.length > 0 ? log.lines : ["(it wrote nothing)"];
    parts.push(list(`End of the log of ${log.process}`, lines));
  }
  return parts;
}

function loopPart(loop: LoopTrace, view: { width: number; span: [number, number]; marks: number[] }): HTMLElement {
  const starts = [...new Set(loop.generation)].join(", ");
  const part = el("section", {}, el("h3", {}, `${loop.process}: ${loop.tick.length} cycles of start ${starts}`));
  if (loop.overruns.length > 0) part.append(list(`${loop.overruns.length} overruns`, worst(loop)));
  const columns = { "late (µs)": loop.late_us, "work (µs)": loop.body_us, ...loop.values };
  for (const [name, values] of Object.entries(columns)) {
    // A flat line says nothing.
    if (values.every((value) => value === values[0])) continue;
    part.append(el("div", { class: "dim" }, name), chart(loop.at_ms, values, view));
  }
  return part;
}

/** The overruns that took longest, in the order of time. */
function worst(loop: LoopTrace): string[] {
  const loss = (index: number) => (loop.late_us[index] ?? 0) + (loop.body_us[index] ?? 0);
  const longest = [...loop.overruns].sort((a, b) => loss(b[0]) - loss(a[0])).slice(0, LISTED);
  return longest
    .sort((a, b) => a[0] - b[0])
    .map(([index, cause]) => {
      const [at, late, work] = [loop.at_ms, loop.late_us, loop.body_us].map((column) => column[index] ?? 0);
      return `${at?.toFixed(1)} ms  tick ${loop.tick[index]}  late ${late?.toFixed(0)} µs  work ${work?.toFixed(0)} µs  ${cause}`;
    });
}

function list(title: string, lines: string[]): HTMLElement {
  return el("section", {}, el("h3", {}, title), el("pre", {}, lines.join("\n")));
}
