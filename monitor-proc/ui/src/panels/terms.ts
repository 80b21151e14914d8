// Terms with a short explanation on hover, focus and tap.
import { el } from "./dom";

/** Each in one or two sentences, for new users. */
const TERMS: Record<string, string> = {
  RT: "Real-time scheduling: the system runs physics and controllers before everything else.",
  "real-time factor": "Simulated seconds per second of the clock: 1 is real time.",
  TCP: "Tool centre point: the point of the tool that targets are about.",
  setpoint: "The joint position that a controller asks the drives for.",
  measured: "What physics, in the place of sensors, reports.",
  error: "Measured minus setpoint: the lag of a joint behind its command.",
  effort: "Torque (N m) or force (N) of a drive, as a share of its limit.",
  "distance to target": "Between the measured TCP and the pose that the arm is led to.",
  clearance: "Distance between an arm's collision spheres and the nearest obstacle.",
  goal: "What the task, or a person, asks the controller for.",
  drops: "Held objects that the gripper lost.",
  resyncs: "Pick-ups that began again because the object had moved.",
  aborts: "Transfers that turned back because the place was gone.",
  recoveries: "Everything else a task did to continue after a disturbance.",
  limits: "Limits of a joint (position, velocity, acceleration) that were exceeded, as physics measured.",
  contacts: "Times an arm touched an obstacle or another arm.",
  "self-contacts": "Times parts of one arm touched each other.",
  decision:
    "What the task asked for last: goals of the arms and grippers. A controller holds the arm when the newest one is too old.",
  policy: "The program that decides: a state machine, a tree, a table or code.",
  guard: "A condition that has to hold before a transition is taken.",
  trigger: "The event that lets a state machine take a transition.",
  tick: "One millisecond of simulated time: each process works once per tick or per several ticks.",
  missed: "Cycles that began too late or took too long.",
  late: "How long after its due time a cycle began.",
  body: "How long the work of a cycle took.",
  p50: "Half of all values are smaller.",
  p99: "99 of 100 values are smaller.",
  "p99.9": "999 of 1000 values are smaller.",
  hop: "The way of a message from one process to the next.",
  keys: "Values that the nodes of a task share: its blackboard.",
  suction: "A vacuum cup; load is the share of the force or torque at which its grip breaks.",
};

/** `text` with its explanation; `key` names the term where the text is another one. */
export function term(text: string, key = text): HTMLElement {
  if (!(key in TERMS)) return el("span", {}, text);
  return el("span", { class: "term", tabindex: 0, "data-term": key, "aria-describedby": "term-note" }, text);
}

/** Shows the explanation of the term under the pointer, with the focus, or touched. */
export function mountTerms(): void {
  const note = el("div", { id: "term-note", role: "tooltip", hidden: true });
  document.body.append(note);
  let shown: HTMLElement | null = null;
  const show = (target: EventTarget | null) => {
    const node = target instanceof Element ? target.closest<HTMLElement>(".term") : null;
    if (node === shown) return;
    shown = node;
    note.hidden = node === null;
    if (node === null) return;
    note.textContent = TERMS[node.dataset.term ?? ""] ?? "";
    const at = node.getBoundingClientRect();
    note.style.left = `${Math.max(4, Math.min(at.left, innerWidth - note.offsetWidth - 4))}px`;
    // Above the term if the window ends below it.
    const below = at.bottom + 4;
    note.style.top = `${below + note.offsetHeight > innerHeight ? at.top - note.offsetHeight - 4 : below}px`;
  };
  for (const kind of ["pointerover", "focusin", "pointerdown"] as const)
    document.addEventListener(kind, ({ target }) => show(target));
  document.addEventListener("focusout", () => show(null));
  document.addEventListener("keydown", ({ key }) => {
    if (key === "Escape") show(null);
  });
  const scrolled = ({ target }: Event) => target instanceof Node && target.contains(shown) && show(null);
  document.addEventListener("scroll", scrolled, { capture: true, passive: true });
}
