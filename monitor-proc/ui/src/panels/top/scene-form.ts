// Which demo, with which policy, seed and speed, and the button that sets it up.
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setOptions, setTitle } from "../dom";

const SPEEDS = ["1", "max", "0.1", "0.5", "2", "5", "10", "50"];

export function sceneForm(desk: Desk): HTMLElement {
  const demo = el("select", { "aria-label": "Demo", class: "demo" });
  const policy = el("select", { "aria-label": "Policy", class: "policy" });
  const seed = el("input", { type: "number", min: 0, value: 0, class: "seed", "aria-label": "Seed" });
  seed.title = "Seed: varies poses and friction within the bounds of the cell file";
  const speed = el("select", { "aria-label": "Speed", class: "speed" });
  speed.title = "1: real time; max or another factor: lockstep";
  setOptions(speed, SPEEDS, "1");

  const chosen = () => desk.store.hello?.demos.find((one) => one.name === demo.value);
  const policies = (wanted?: string) => {
    const known = chosen()?.policies ?? (wanted === undefined ? [] : [wanted]);
    setOptions(policy, known, wanted ?? chosen()?.default_policy);
    setTitle(demo, chosen()?.description ?? "Demo");
  };
  demo.addEventListener("change", () => policies());
  desk.store.on("hello", ({ demos, run }) => {
    // A recording has its own demo only.
    setOptions(demo, demos.length > 0 ? demos.map((one) => one.name) : [run.demo], run.demo);
    policies(run.policy);
    seed.value = String(run.seed);
    setOptions(speed, SPEEDS.includes(run.speed) ? SPEEDS : [run.speed, ...SPEEDS], run.speed);
  });

  const create = button(desk, {
    label: "Create scene",
    class: "create",
    about: () => "Set this scene up in the place of the one that runs; it waits for Play",
    twin: () =>
      `robocell load ${demo.value} --policy ${policy.value} --seed ${seed.value} --speed ${speed.value}`,
    why: () => desk.cellRefusal() ?? (demo.value === "" ? "no demo is known yet" : null),
    run: async () => {
      const done = await desk.send({
        do: "load",
        demo: demo.value,
        policy: policy.value,
        seed: Math.max(0, Math.round(Number(seed.value) || 0)),
        speed: speed.value,
      });
      if (done) desk.say(`${demo.value} is being set up; Play starts it`);
    },
  });
  return el(
    "div",
    { class: "group scene-form", role: "group", "aria-label": "Scene" },
    demo,
    policy,
    el("label", {}, "seed", seed),
    el("label", {}, "speed", speed),
    create,
  );
}
