// What is known of the selected object: where it is, how it moves, what touches it.
import type { Scene, Vec3 } from "../net/protocol";
import { type Contact, type ContactBody, OBJECT, type ObjectState } from "../net/snapshot";
import { button } from "./button";
import type { Desk } from "./desk";
import { el, setText } from "./dom";
import { toRpy } from "./robot/rotation";

const DEG = 180 / Math.PI;

type Row = (object: ObjectState, index: number) => string;

/** Mounts the card over the view; it shows what is selected there or in the scene tree. */
export function mountInspector(desk: Desk, host: HTMLElement): void {
  const card = el("section", { class: "inspector", "aria-label": "Selected object", hidden: true });
  host.append(card);
  const close = () => desk.view?.select(null);
  const open = (name: string | null) => {
    const index = desk.store.scene?.objects.findIndex((one) => one.name === name) ?? -1;
    card.hidden = index < 0;
    card.replaceChildren(...(index < 0 || desk.store.scene === null ? [] : cardOf(desk, desk.store.scene, index, close)));
  };
  desk.view?.onSelect(open);
  desk.store.on("scene", () => open(null));
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !card.hidden) close();
  });
}

function cardOf(desk: Desk, scene: Scene, index: number, close: () => void): HTMLElement[] {
  const spec = scene.objects[index];
  if (spec === undefined) return [];
  const rows: [string, Row][] = [
    ["position (m)", ({ pose }) => pose.slice(0, 3).map((x) => x.toFixed(3)).join(" ")],
    ["roll pitch yaw (°)", ({ pose }) => toRpy([pose[3], pose[4], pose[5], pose[6]]).map((x) => (x * DEG).toFixed(1)).join(" ")],
    ["speed (m/s)", ({ linear }) => Math.hypot(...linear).toFixed(3)],
    ["turn (°/s)", ({ angular }) => (Math.hypot(...angular) * DEG).toFixed(1)],
    ["mass (kg)", () => spec.mass_kg.toFixed(3)],
    ["friction", () => spec.friction.toFixed(2)],
    ["state", ({ flags }) => stateOf(flags)],
    ["held by", (_, at) => holderOf(desk, at)],
  ];
  const cells = rows.map(([name, read]) => ({ name, read, node: el("dd", { class: "num" }) }));
  const contacts = el("dl", { "aria-label": "Contacts" });
  const shut = el("button", { type: "button", class: "button icon-only quiet", "aria-label": "Close", title: "Close (Escape)" }, "×");
  shut.addEventListener("click", close);
  const list = el("dl", {}, ...cells.flatMap(({ name, node }) => [el("dt", {}, name), node]));
  desk.pulse.add(list, () => {
    const object = desk.snapshot?.objects[index];
    if (object === undefined) return;
    for (const { read, node } of cells) setText(node, read(object, index));
    showContacts(contacts, scene, desk.snapshot?.contacts ?? [], index);
  });
  return [
    el("div", { class: "row" }, el("h2", {}, spec.name), el("span", { class: "spacer" }), shut),
    list,
    el("h3", { title: "Forces along the contact normals, at 50 Hz; none in the past" }, "Contacts"),
    contacts,
    dragForm(desk, spec.name, index),
  ];
}

function stateOf(flags: number): string {
  if ((flags & OBJECT.enabled) === 0) return "not in the scene";
  if ((flags & OBJECT.dragged) !== 0) return "dragged";
  if ((flags & OBJECT.touched) !== 0) return "touched by an arm";
  return (flags & OBJECT.asleep) !== 0 ? "at rest" : "free";
}

function holderOf(desk: Desk, index: number): string {
  const arm = desk.snapshot?.arms.findIndex((one) => one.held === index) ?? -1;
  return arm < 0 ? "–" : desk.armName(arm);
}

/** The partners of object `index`, the hardest first. */
function showContacts(list: HTMLElement, scene: Scene, contacts: Contact[], index: number): void {
  const isIt = (body: ContactBody) => body.kind === "object" && body.index === index;
  const found = contacts.filter(({ a, b }) => isIt(a) || isIt(b)).slice(0, 6);
  const texts: [string, string][] = found.map(({ a, b, force }) => [nameOf(scene, isIt(a) ? b : a), `${Math.hypot(...force).toFixed(2)} N`]);
  if (texts.length === 0) texts.push(["none", ""]);
  const shown = texts.flatMap(([name, force]) => [name, force]);
  const same = list.childElementCount === shown.length && shown.every((text, at) => list.children[at]?.textContent === text);
  if (same) return;
  list.replaceChildren(...texts.flatMap(([name, force]) => [el("dt", {}, name), el("dd", { class: "num" }, force)]));
}

function nameOf(scene: Scene, body: ContactBody): string {
  const all = { object: scene.objects, fixture: scene.fixtures, arm: scene.arms }[body.kind];
  return all[body.index]?.name ?? body.kind;
}

function dragForm(desk: Desk, name: string, index: number): HTMLElement {
  const inputs = ["x", "y", "z"].map((axis, at) => {
    const input = el("input", { type: "number", step: 0.01, "aria-label": `${axis} (m)`, title: `${axis} in metres, world frame` });
    input.value = (desk.snapshot?.objects[index]?.pose[at] ?? 0).toFixed(3);
    return input;
  });
  const place = () => inputs.map((input) => Number.parseFloat(input.value)) as Vec3;
  const go = button(desk, {
    label: "Drag there",
    class: "small",
    about: () => "Pull the object there with a spring of at most 80 N",
    twin: () => `robocell drag ${name} --to ${place().join(" ")}`,
    why: () => desk.cellRefusal() ?? (place().every(Number.isFinite) ? null : "a field is empty"),
    run: () => desk.send({ do: "drag", object: name, to: place(), for_s: 2 }),
  });
  const copy = button(desk, {
    label: "Copy pose",
    class: "small",
    about: () => "Copy position (m) and orientation (w, x, y, z)",
    twin: () => null,
    run: async () => {
      const pose = (desk.snapshot?.objects[index]?.pose ?? []).map((x) => x.toFixed(5)).join(" ");
      const copied = await navigator.clipboard?.writeText(pose).then(() => true, () => false);
      desk.say(copied === true ? `Copied ${pose}` : pose);
    },
  });
  const form = el("form", { "aria-label": `Drag ${name}` }, el("div", { class: "target-fields" }, ...inputs), el("div", { class: "row" }, go, copy));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    go.click();
  });
  return form;
}
