// Which demo, with which policy, seed and speed, and the button that sets it up.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setOptions, setText, setTitle } from "../dom";

const SPEEDS = ["0.1", "0.5", "1", "2", "5", "10", "50", "max"];

/** As fast as a page can show it. */
const FASTEST_REPLAY = 50;

/** Why the speed cannot be changed now, or null. */
function speedRefusal(context: PanelContext): string | null {
  return context.store.hello?.live === false ? context.refusal() : context.cellRefusal();
}

function speedTwin(context: PanelContext, speed: string): string {
  return context.store.hello?.live === false ? "robocell replay FILE" : `robocell speed ${speed}`;
}

/** Of the running cell, or of the recording that is shown. */
async function changeSpeed(context: PanelContext, speed: string): Promise<void> {
  if (context.store.hello?.live === false) {
    const factor = speed === "max" ? FASTEST_REPLAY : Number(speed);
    // Without a time the recording would go to its beginning.
    await context.send({ do: "seek", time_s: context.snapshot?.time ?? 0, speed: factor, play: !context.paused });
    return;
  }
  await context.send({ do: "speed", speed });
}

function showSpeed(select: HTMLSelectElement, speed: string): void {
  setOptions(select, SPEEDS.includes(speed) ? SPEEDS : [speed, ...SPEEDS], speed);
}

export function sceneForm(context: PanelContext): HTMLElement {
  const demo = el("select", { "aria-label": "Demo", class: "demo" });
  const policy = el("select", { "aria-label": "Policy", class: "policy" });
  const seed = el("input", { type: "number", min: 0, value: 0, class: "seed", "aria-label": "Seed" });
  seed.title = "Seed: varies poses and friction within the bounds of the cell file";
  const speed = el("select", { "aria-label": "Speed", class: "speed" });
  setOptions(speed, SPEEDS, "1");
  speed.addEventListener("change", () => void changeSpeed(context, speed.value));

  const chosen = () => context.store.hello?.demos.find((one) => one.name === demo.value);
  const policies = (wanted?: string) => {
    const known = chosen()?.policies ?? (wanted === undefined ? [] : [wanted]);
    setOptions(policy, known, wanted ?? chosen()?.default_policy);
    setTitle(demo, chosen()?.description ?? "Demo");
  };
  demo.addEventListener("change", () => policies());
  context.store.on("hello", ({ demos, run }) => {
    // A recording has its own demo only.
    setOptions(demo, demos.length > 0 ? demos.map((one) => one.name) : [run.demo], run.demo);
    policies(run.policy);
    seed.value = String(run.seed);
    showSpeed(speed, run.speed);
  });
  context.store.on("status", (status) => {
    if (status.speed !== null && context.store.hello?.live !== false && document.activeElement !== speed)
      showSpeed(speed, status.speed);
  });

  // What was chosen and is not what runs is not in force yet.
  const pending = () => {
    const run = context.store.hello?.run;
    if (run === undefined || context.cellRefusal() !== null) return false;
    const chosen = [demo.value, policy.value, seed.value];
    return chosen.join() !== [run.demo, context.store.status?.task.policy || run.policy, run.seed].join();
  };
  const create = button(context, {
    label: "Create scene",
    class: "create",
    name: () => (pending() ? "Create scene *" : "Create scene"),
    about: () =>
      `Replace the scene that runs by this one, which waits for Play${pending() ? ". The choices are not applied yet" : ""}`,
    twin: () => `robocell load ${demo.value} --policy ${policy.value} --seed ${seed.value} --speed ${speed.value}`,
    why: () => context.cellRefusal() ?? (demo.value === "" ? "no demo is known yet" : null),
    run: async () => {
      const done = await context.send({
        do: "load",
        demo: demo.value,
        policy: policy.value,
        seed: Math.max(0, Math.round(Number(seed.value) || 0)),
        speed: speed.value,
      });
      if (done) context.notify(`${demo.value} is being set up; Play starts it`);
    },
  });
  const form = el(
    "div",
    { class: "group scene-form", role: "group", "aria-label": "Scene" },
    demo,
    policy,
    el("label", {}, "seed", seed),
    el("label", {}, "speed", speed),
    create,
  );
  const attrs = { class: "button scene-open", title: "Choose demo, policy, seed and speed" };
  const opener = plainButton(attrs, () => open(!form.classList.contains("open")));
  const open = (on: boolean) => {
    form.classList.toggle("open", on);
    setAttr(opener, "aria-expanded", String(on));
  };
  open(false);
  document.addEventListener("pointerdown", (event) => {
    if (!event.composedPath().includes(form) && !event.composedPath().includes(opener)) open(false);
  });
  form.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    open(false);
    opener.focus();
  });
  context.store.on("scene", () => open(false));
  // A task that was restarted with another policy runs that one.
  let policyNow = "";
  context.store.on("status", ({ task }) => {
    if (task.policy === "" || task.policy === policyNow) return;
    policyNow = task.policy;
    if (demo.value === context.store.hello?.run.demo) policies(task.policy);
  });
  context.pulse.add(null, () => {
    const run = context.store.hello?.run;
    const twin = context.onCell(speedTwin(context, speed.value));
    setTitle(speed, `Speed, changed at once. 1: real time; max or another factor: lockstep\n$ ${twin}`);
    speed.disabled = speedRefusal(context) !== null;
    setText(opener, run === undefined ? "Scene ▾" : `${run.demo} · ${policyNow || run.policy} ▾`);
    create.classList.toggle("pending", pending());
  });
  return el("div", { class: "scene" }, opener, form);
}
