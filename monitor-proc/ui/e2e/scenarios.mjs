// What a person does on the page, and what has to come of it.
import { existsSync } from "node:fs";
import { bins, flip, manual, pallet } from "./bins.mjs";
import { breakpoints, breakspots, code, policy, saved } from "./debug.mjs";
import { guide, reach, scenes, sharp, views } from "./first.mjs";
import { flag, NOT_LIVE, noFlag, PAUSED, starts, TASK_PAUSED } from "./flags.mjs";
import { drawing, guards, largeTree, outline } from "./graph.mjs";
import { grasp, jog } from "./guiding.mjs";
import { hands } from "./hands.mjs";
import { inspector } from "./inspect.mjs";
import { answers, drawing as jobDrawing, load } from "./jobs.mjs";
import { joints, ticks } from "./joints.mjs";
import { keyboard } from "./keyboard.mjs";
import { levels, phone, readable } from "./looks.mjs";
import { recorded, status, told } from "./status.mjs";
import { targets } from "./targets.mjs";
import { earlier, filter, lanes, replaySpeed, speed } from "./time.mjs";
import { windows } from "./windows.mjs";

/** What a browser says while the monitor is away. */
const CLOSED = /WebSocket connection to|ERR_CONNECTION_REFUSED/;

/** Bodies and robots are drawn where physics has them. */
async function draws({ look, until, near, same, page, robocell }) {
  // The task shows itself with its first decision. Bins and parts come later.
  robocell("task", "start");
  const steps = (await look((r) => r.store.scene.conveyor ?? r.store.scene.dispenser)) ? 4000 : 20;
  robocell("step", String(steps));
  await until("it stepped", (r, steps) => r.store.snapshot.tick >= steps, steps);
  // Following the operator takes no picture.
  await until(
    "the policy is drawn",
    (r) => r.store.scene.demo === "reach" || r.store.graphs.some(({ nodes }) => nodes.length > 1),
  );
  const seen = await look((r) => ({
    bodies: r.view.bodyPositions(),
    objects: r.store.scene.objects.map(({ name }, index) => ({
      name,
      at: r.store.snapshot.objects[index].pose.slice(0, 3),
      enabled: (r.store.snapshot.objects[index].flags & 1) !== 0,
    })),
    arms: r.store.scene.arms.map((arm, index) => ({
      name: arm.name,
      link: r.view.linkPositions(index)[arm.tool_link],
      reach: Math.hypot(...arm.tool.slice(0, 3)),
      tcp: r.store.snapshot.arms[index].tcp.slice(0, 3),
    })),
  }));
  // What waits to be brought in is not drawn.
  const here = seen.objects.filter(({ enabled }) => enabled);
  same("what is drawn", Object.keys(seen.bodies).sort(), here.map(({ name }) => name).sort());
  for (const { name, at } of here) near(name, seen.bodies[name], at, 1e-3);
  const [crowded, inCrowds] = await look((r) => {
    const isInCrowd = ({ group }) => group.visible && group.children[0].layers.mask !== 1;
    return [
      r.view.cell.bodies.filter(isInCrowd).length,
      r.view.cell.crowds.reduce((sum, { mesh }) => sum + mesh.count, 0),
    ];
  });
  same("equal bodies that are drawn at once", inCrowds, crowded);
  for (const { name, link, reach, tcp } of seen.arms) {
    // The tool is in the last link's frame, at a distance of `reach`.
    const off = Math.hypot(...tcp.map((x, axis) => x - link[axis]));
    if (Math.abs(off - reach) > 3e-3) throw new Error(`the tool of ${name} is ${off - reach} m off`);
  }
  await until("processes are listed", (r) => r.store.status.processes.length >= 4);
  const shot = await page.screenshot();
  if (shot.length < 30_000) throw new Error(`the page is empty: ${shot.length} bytes of PNG`);
}

/** Pulls a cube towards the viewer, then a placed one out of the stack, with the mouse. */
async function drag(test) {
  const { page, look, until, press } = test;
  await press("robocell resume");
  await pullNearer(test);
  await until("the red cube is placed and the hand is away", (r) => {
    const { placed, phase } = r.store.status.task;
    return placed.includes("red_cube") && !["RELEASE", "LOWER"].includes(phase);
  });
  const index = await look((r) => r.store.scene.objects.findIndex(({ name }) => name === "red_cube"));
  const before = await look((r, i) => r.store.snapshot.objects[i].pose.slice(0, 3), index);
  const lines = await look((r) => r.store.log.length);
  const [x, y] = await look((r) => r.view.screenOf("red_cube"));
  await page.keyboard.down("Shift");
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 10; step++) {
    await page.mouse.move(x - 12 * step, y + 3 * step);
    await page.waitForTimeout(60);
  }
  await until(
    "physics moved the cube",
    (r, { index, before }) => {
      const at = r.store.snapshot.objects[index].pose;
      return Math.hypot(at[0] - before[0], at[1] - before[1]) > 0.06;
    },
    { index, before },
  );
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await until(
    "the log tells of the recovery",
    (r, lines) => r.store.log.slice(lines).some(({ mark }) => ["abort", "resync", "recover", "drop"].includes(mark)),
    lines,
  );
  await until("the job continues", (r) => r.store.status.task.outcome === "running");
}

/** A pull down the screen moves a cube across the table, and not into it; a press beside the cube takes it, too, and
 * one on nothing leaves the camera alone. */
async function pullNearer({ page, look, until, same }) {
  const name = "yellow_cube";
  const index = await look((r, name) => r.store.scene.objects.findIndex((one) => one.name === name), name);
  const pose = () => look((r, i) => r.store.snapshot.objects[i].pose.slice(0, 3), index);
  const before = await pose();
  const [x, y] = await look((r, name) => r.view.screenOf(name), name);
  const hint = page.locator(".pointer-hint");
  const isOn = async (px) => {
    await page.mouse.move(px, y);
    await page.waitForTimeout(200);
    return (await hint.isVisible()) && (await hint.innerText()).includes(`moves ${name}`);
  };
  let beside = x;
  // On the side where no other cube is near.
  while (await isOn(beside)) beside -= 2;
  await page.keyboard.down("Shift");
  await page.mouse.move(beside - 6, y);
  await page.mouse.down();
  for (let step = 1; step <= 10; step++) {
    // Not over the edge of the table: a slow page sees the cube late.
    await page.mouse.move(beside - 6, y + 6 * step);
    await page.waitForTimeout(60);
  }
  await page.locator(".label", { hasText: /^\d+ mm to / }).waitFor();
  await until(
    "physics moved the cube across the table",
    (r, [i, before]) => {
      const [x, y, z] = r.store.snapshot.objects[i].pose;
      return Math.hypot(x - before[0], y - before[1]) > 0.06 && Math.abs(z - before[2]) < 0.01;
    },
    [index, before],
  );
  await page.mouse.up();
  const address = page.url();
  const frame = await page.locator("#view").boundingBox();
  await page.mouse.move(frame.x + 20, frame.y + 20);
  await page.mouse.down();
  await page.mouse.move(frame.x + 120, frame.y + 80, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await page.waitForTimeout(500);
  same("the address after Shift and a drag of nothing", page.url(), address);
}

/** Leads the arm by the target while the task is paused. */
async function gizmo({ page, look, until, press, near }) {
  await starts({ press, until });
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await until("the arm is at rest", (r) => {
    const { velocities, accelerations } = r.store.snapshot.arms[0];
    return [...velocities, ...accelerations].every((rate) => Math.abs(rate) < 1e-3);
  });
  const before = await look((r) => r.store.snapshot.arms[0].tcp.slice(0, 3));
  const [x, y] = await look((r) => r.view.screenOf("gizmo z"));
  await page.mouse.move(x, y);
  await page.waitForTimeout(300);
  await page.mouse.down();
  for (let step = 1; step <= 8; step++) {
    await page.mouse.move(x, y - 8 * step);
    await page.waitForTimeout(60);
  }
  await page.mouse.up();
  await until(
    "the arm followed",
    (r, before) => {
      const at = r.store.snapshot.arms[0].tcp;
      return Math.hypot(...before.map((x, axis) => at[axis] - x)) > 0.03;
    },
    before,
  );
  const where = await look((r) => ({
    target: r.store.snapshot.arms[0].target.slice(0, 3),
    valid: r.store.snapshot.arms[0].targetValid,
  }));
  if (!where.valid) throw new Error("the target is not shown");
  await until(
    "the tool is at the target",
    (r, target) => Math.hypot(...target.map((x, a) => r.store.snapshot.arms[0].tcp[a] - x)) < 0.02,
    where.target,
  );
  near("the target", where.target, [before[0], before[1], where.target[2]], 0.01);
}

/** Each button does what its command does. */
async function buttons({ page, look, until, press, robocell, same, near, forgive }) {
  const generation = (name) => look((r, n) => r.store.status.processes.find((p) => p.name === n).generation, name);
  // Simulated time.
  robocell("pause");
  await until("the command paused", flag(PAUSED));
  await press("robocell resume");
  await until("the button resumed", noFlag(PAUSED));
  await press("robocell pause");
  await until("the button paused", flag(PAUSED));
  const tick = await look((r) => r.store.snapshot.tick);
  const steps = Number(
    (await page.locator('button[title*="$ robocell step"]').first().getAttribute("title")).match(/step (\d+)/)[1],
  );
  await press("robocell step");
  await until("it stepped", (r, to) => r.store.snapshot.tick === to, tick + steps);
  robocell("step", String(steps));
  await until("the command steps alike", (r, to) => r.store.snapshot.tick === to, tick + 2 * steps);
  await press("robocell reset");
  const bodies = () => look((r) => r.view.bodyPositions());
  // Late frames of a loaded machine still show the scene of before.
  await until("the scene is back", (r) => {
    const { positions, velocities } = r.store.snapshot.arms[0];
    const home = r.store.scene.arms[0].joints.map((joint) => joint.home);
    const isHome = home.every((at, index) => Math.abs(positions[index] - at) < 0.01);
    return isHome && [...velocities].every((rate) => Math.abs(rate) < 1e-3);
  });
  await page.waitForTimeout(300);
  const after = await bodies();
  robocell("reset");
  await page.waitForTimeout(300);
  // A view at rest draws no motion of less than it can show.
  const again = await bodies();
  same("what is in the scene after the command", Object.keys(again).sort(), Object.keys(after).sort());
  for (const [name, at] of Object.entries(after)) near(`${name} after the command`, again[name], at, 1e-4);
  robocell("resume");
  // The task.
  await until("the task works", (r) => r.store.status.task.outcome === "running");
  await press("robocell task pause");
  await until("the button paused the task", flag(TASK_PAUSED));
  robocell("task", "resume");
  await until("the command resumed it", noFlag(TASK_PAUSED));
  robocell("task", "pause");
  await until("the command paused it", flag(TASK_PAUSED));
  // The hand is led while the task is paused; one button opens and closes.
  await page.keyboard.press("g");
  await until("the hand closes", (r) => r.store.snapshot.arms[0].width < 0.06);
  robocell("gripper", "open");
  await until("the command opens it", (r) => r.store.snapshot.arms[0].width > 0.075);
  await press("robocell task resume");
  await until("the button resumed the task", noFlag(TASK_PAUSED));
  const lines = await look((r) => r.store.log.length);
  await press("robocell task reset");
  await until(
    "the task restarted",
    (r, lines) => r.store.log.slice(lines).some(({ text }) => text.includes("[task] reset")),
    lines,
  );
  await until("the task waits", flag(TASK_PAUSED));
  // An action that is refused now gives the reason, and is not offered first. Time is
  // paused at the start of the task: a slow page would look after its end.
  robocell("pause");
  robocell("reset");
  robocell("task", "resume");
  robocell("step", "100");
  await until("the task works again", (r) => r.store.status.task.outcome === "running");
  const perform = page.locator("#right").getByRole("button", { name: "Perform Task" });
  await page.locator('button[title*="Not now: the task is running"]').first().waitFor();
  same("the button of a running task is off", await perform.getAttribute("aria-disabled"), "true");
  same("it is not the primary one", (await perform.getAttribute("class")).includes("primary"), false);
  robocell("resume");
  // Processes.
  const task = await generation("task");
  await press("robocell restart task");
  await until("a new task", (r, n) => r.store.status.processes.find((p) => p.name === "task").generation > n, task);
  // A kept recording outlives the scene it was recorded in.
  await page.getByRole("button", { name: "More of the recorder" }).click();
  await press("robocell record last 10s");
  const said = await page.locator(".toast", { hasText: ".mcap" }).innerText();
  const kept = said.match(/\/\S*\.mcap/)[0];
  // Another scene on the same page.
  await page.locator(".scene-open").click();
  await page.selectOption("select.demo", "franka-pyramid");
  await press("robocell load franka-pyramid");
  await until("the other scene", (r) => r.store.scene.demo === "franka-pyramid" && r.store.snapshot.arms.length === 2);
  await until("it waits for Play", flag(PAUSED));
  if (!existsSync(kept)) throw new Error(`${kept} was deleted with the scene`);
  forgive(CLOSED);
}

/** Every process that is killed is told of at once: a toast, a line, a mark, a reason. */
async function crashes({ page, look, until, press, same, forgive }) {
  const lines = (text) => look((r, text) => r.store.log.filter((line) => line.text.includes(text)).length, text);
  await starts({ press, until });
  await until("some seconds are recorded", (r) => r.store.timeline?.to_s > 3);
  // A toast is shown for seconds. On a loaded machine it may be gone before anything looks again.
  await page.evaluate(() => {
    window.toasts = [];
    const shown = (change) => [...change.addedNodes].filter((node) => node.matches(".toast.bad"));
    const keep = (changes) => window.toasts.push(...changes.flatMap(shown).map((node) => node.textContent));
    new MutationObserver(keep).observe(document.querySelector(".toasts"), { childList: true });
  });
  const kill = async (name) => {
    const pid = await look((r, n) => r.store.status.processes.find((p) => p.name === n).pid, name);
    process.kill(pid, "SIGKILL");
    await until(
      `a toast tells that ${name} was killed`,
      (_, text) => window.toasts.some((toast) => toast.includes(text)),
      `${name} was killed (SIGKILL)`,
    );
  };
  await kill("physics");
  await until("the restart of physics is told", (r) =>
    r.store.log.some(({ text, mark }) => mark === "restart" && text.includes("physics restarted: start 2")),
  );
  const back = /physics restarted: start 2, stepped back \d+\.\d\d s, to \d+\.\d{3} s; that time is repeated/;
  const line = await look((r) => r.store.log.find(({ text }) => text.includes("physics restarted")).text);
  if (!back.test(line)) throw new Error(`the line says ${line}`);
  // Time was set back to the snapshot: the timeline ends with the newest state.
  await until("the new epoch is recorded", (r) => r.store.timeline.epochs.length === 2);
  const { epochs, to_s: end } = await look((r) => r.store.timeline);
  // Not that it began before the first one ended: on a loaded machine the last
  // states before the kill, or the first after it, reach no recorder.
  same("the newest epoch resumed after the first began", epochs[1].from_s > epochs[0].from_s, true);
  same("the timeline ends with the newest epoch", end, epochs[1].to_s);
  same("the timeline begins with the first", (await look((r) => r.store.timeline.from_s)) < epochs[1].from_s, true);
  // What failed in the part of the history that was discarded keeps its mark.
  const marks = await plant(page, {
    time_s: epochs[1].from_s + 0.2,
    text: "planted",
    mark: "restart",
    epoch: epochs[0].epoch,
  });
  same("marks of the discarded part", marks.filter((title) => title.includes("planted")).length, 1);
  await kill("controller-0");
  await until("the restart of the controller is told", (r) =>
    r.store.log.some(({ text }) => text.includes("controller-0 restarted")),
  );
  await kill("task");
  await until("the restart of the task is told", (r) =>
    r.store.log.some(({ text, mark }) => mark === "restart" && text.startsWith("[task] ")),
  );
  // The log outlives the monitor and a reload, and so does the moment looked at.
  const nodes = await look((r) => r.store.graphs[0].nodes.length);
  const text = await page.locator("#right").innerText();
  const pid = await look((r) => r.store.status.processes.find((p) => p.name === "monitor").pid);
  process.kill(pid, "SIGKILL");
  await until("the connection is lost", (r) => !r.store.connected);
  // Nothing that was there is taken away meanwhile.
  if ((await page.locator("#right").innerText()).length < text.length / 2) {
    throw new Error("the panels are emptied while the monitor is away");
  }
  await until(
    "it is back",
    (r) => r.store.connected && r.store.log.some(({ text }) => text.includes("monitor restarted: start 2")),
  );
  for (const name of ["physics", "controller-0", "task", "monitor"]) {
    await page
      .locator(`.marks [data-mark=incident][title*="${name} was killed (SIGKILL)"]`)
      .waitFor({ state: "attached" });
    // The task tells of its restart itself.
    const told = name === "task" ? "[task] " : `${name} restarted: start 2`;
    await page.locator(`.marks [data-mark=restart][title*="${told}"]`).first().waitFor({ state: "attached" });
  }
  same("how often it is told that physics was killed", await lines("physics was killed"), 1);
  // Two failures of one incident that are apart on the bar have a mark each.
  const failures = [
    [0.5, "one failure"],
    [epochs[0].to_s - 0.5, "another failure"],
  ];
  const planted = failures.map(([time_s, text]) => ({
    time_s,
    text,
    mark: "incident",
    incident: 9,
    epoch: epochs[1].epoch,
  }));
  const titles = await plant(page, ...planted);
  for (const [, text] of failures) {
    same(`marks of ${text}`, titles.filter((title) => title.includes(text)).length, 1);
  }
  await until("the tree is the same", (r, nodes) => r.store.graphs[0]?.nodes.length === nodes, nodes);
  await opensIncident(page, "physics");
  const seek = async (time_s) => {
    const ack = await page.evaluate((time_s) => window.robocell.store.command({ do: "seek", time_s }), time_s);
    if (!ack.ok) throw new Error(`seek: ${ack.message}`);
  };
  await seek(2);
  await until("the past is shown", flag(NOT_LIVE));
  await page.reload();
  await until(
    "the same moment is shown",
    (r) => r?.store.snapshot !== null && Math.abs(r.store.snapshot.time - 2) < 0.05 && r.store.past !== null,
  );
  same("how often it is told after a reload", await lines("physics was killed"), 1);
  same("lines of the list", await page.locator(".event", { hasText: "physics was killed" }).count(), 1);
  await seek(null);
  await until("it is live again", noFlag(NOT_LIVE));
  if ((await page.evaluate(() => location.hash)).includes("t=")) throw new Error("the URL still names the moment");
  forgive(CLOSED);
}

/**
 * Puts lines into the log of the page and returns the titles of all marks then, in one turn
 * of the page: the monitor may send the whole log again at any time, without these lines.
 */
function plant(page, ...lines) {
  const planted = lines.map((line) => ({ kind: "lifecycle", ...line }));
  return page.evaluate((lines) => {
    window.robocell.store.takeText({ t: "log", lines });
    return [...document.querySelectorAll(".marks [data-mark]")].map((mark) => mark.title);
  }, planted);
}

/** The mark of an incident on the timeline opens its sheet. */
async function opensIncident(page, name) {
  await page.locator(`.marks button[data-mark=incident][title*="${name} was killed"]`).first().click();
  const sheet = page.locator("dialog.incident");
  const text = await sheet.innerText();
  for (const part of [`Incident 1: ${name} was killed (SIGKILL)`, "controller-0: ", `End of the log of ${name}`]) {
    if (!text.includes(part)) throw new Error(`the incident's sheet lacks "${part}": ${text}`);
  }
  if ((await sheet.locator("canvas").count()) < 4) throw new Error("the incident's sheet has no plots");
  if (process.env.PAGE_SHOT) await page.screenshot({ path: `${process.env.PAGE_SHOT}-incident.png` });
  // The next failure, which may share its mark with this one, is one click away.
  await sheet.getByRole("button", { name: "Incident 2" }).click();
  await page.locator("dialog.incident", { hasText: /Incident 2: \S+ was killed \(SIGKILL\)/ }).waitFor();
  await sheet.getByRole("button", { name: "Close" }).click();
  await sheet.waitFor({ state: "detached" });
}

/** Back to what just happened, and forth to now. */
async function scrub({ page, look, until, press, same }) {
  const seen = () =>
    look((r) => ({ time: r.store.snapshot.time, phase: r.store.status.task.phase, letters: r.store.letters[0] }));
  await starts({ press, until });
  await until("a node is running", (r) => r.store.letters[0]?.includes("R"));
  // A moment within a phase.
  let [then, later] = [await seen(), await seen()];
  while (later.time < then.time + 0.3 || later.phase !== then.phase || later.letters !== then.letters) {
    await page.waitForTimeout(400);
    [then, later] = [later, await seen()];
  }
  await until("the task has continued", (r, phase) => r.store.status.task.phase !== phase, then.phase);
  const time = (then.time + later.time) / 2;
  await until("the flight recorder holds it", (r, t) => r.store.timeline?.to_s > t + 1, time);
  const ack = await page.evaluate((t) => window.robocell.store.command({ do: "seek", time_s: t }), time);
  if (!ack.ok) throw new Error(`seek: ${ack.message}`);
  await until("the past is shown", flag(NOT_LIVE));
  await until("the right moment", (r, t) => Math.abs(r.store.snapshot.time - t) < 0.05, time);
  const past = async () => {
    const { phase, letters } = await seen();
    same("the task then", { phase, letters }, { phase: then.phase, letters: then.letters });
  };
  await past();
  // States of now that arrive meanwhile are not shown.
  await page.waitForTimeout(1500);
  await past();
  await page.evaluate(() => window.robocell.store.command({ do: "seek", time_s: null }));
  await until("it is live again", noFlag(NOT_LIVE));
  await until(
    "so is the task",
    (r, t) => r.store.past === null && r.store.letters[0]?.includes("R") && r.store.snapshot.time > t + 1,
    time,
  );
}

/** Plots show the past that is looked at, and the last seconds afterwards. */
async function plots({ page, look, until, same }) {
  // Two plots with this many samples that are numbers, and the moment they mark.
  const shown = () =>
    page.evaluate(() =>
      [...document.querySelectorAll(".plot")].map(({ plot }) => {
        const [times, ...columns] = plot.data();
        const numbers = (columns[0] ?? []).filter((value) => value !== null).length;
        return { from: times[0], to: times.at(-1), numbers, cursor: plot.cursor() };
      }),
    );
  const until_shown = async (what, fits) => {
    for (let look = 0; look < 200; look++) {
      const now = await shown();
      if (now.length === 2 && now.every(fits)) return now;
      await page.waitForTimeout(50);
    }
    throw new Error(`${what}: ${JSON.stringify(await shown())}`);
  };
  await page.getByRole("tab", { name: "Plots" }).click();
  await until("ten seconds are recorded", (r) => r.store.timeline?.to_s > 10);
  // A page that was opened late shows what came before.
  await page.reload();
  await until("the page shows the cell", (r) => r?.settled());
  await until_shown("the past of a late page", ({ from, to, numbers }) => to - from > 9 && numbers > 100);
  await page.evaluate(() => window.robocell.store.command({ do: "seek", time_s: 5 }));
  await until("the past is shown", flag(NOT_LIVE));
  await until_shown(
    "the past",
    (one) => one.from < 5 && one.to > 5 && one.numbers > 100 && Math.abs(one.cursor - 5) < 0.1,
  );
  // A click on a plot looks at that moment.
  await page
    .locator(".plot .u-over")
    .first()
    .click({ position: { x: 60, y: 20 } });
  await until("another moment is shown", (r) => Math.abs(r.store.snapshot.time - 5) > 0.5);
  const [{ cursor }] = await until_shown("the moment clicked at", (one) => Math.abs(one.cursor - 5) > 0.5);
  same(
    "the moment of the plot and of the view",
    Math.abs(cursor - (await look((r) => r.store.snapshot.time))) < 0.05,
    true,
  );
  if (process.env.PAGE_SHOT) await page.screenshot({ path: `${process.env.PAGE_SHOT}-plots.png` });
  await page.evaluate(() => window.robocell.store.command({ do: "seek", time_s: null }));
  await until("it is live again", noFlag(NOT_LIVE));
  await until_shown(
    "what was missed meanwhile",
    ({ from, to, numbers, cursor }) => to - from > 10 && numbers > 100 && cursor === null,
  );
}

/** With the viewer's link a person can only look, until the operator's token is presented. */
async function viewer({ page, look, until, press, same, robocell, forgive }) {
  same("the role", await look((r) => r.store.hello.role), "viewer");
  const refused = await page.evaluate(() => window.robocell.store.command({ do: "resume" }));
  if (refused.ok || !/operator/.test(refused.message)) {
    throw new Error(`a viewer's command: ${JSON.stringify(refused)}`);
  }
  robocell("step", "20");
  await until("the picture follows all the same", (r) => r.store.snapshot.tick >= 20);
  const token = new URL(process.env.OPERATOR_LINK).searchParams.get("token");
  const field = page.locator('input[aria-label="Operator token"]');
  const present = async (text) => {
    if (!(await field.isVisible())) await page.click("button.role");
    await field.fill(text);
    await field.press("Enter");
  };
  await present("0".repeat(32));
  await page.getByText("that is not the operator's token").waitFor();
  // The browser tells of the answer by itself.
  forgive(/403/);
  same("the role", await look((r) => r.store.hello.role), "viewer");
  // With the right one the page loads again.
  await Promise.all([page.waitForEvent("load"), present(token)]);
  await until("the page is the operator's", (r) => r?.store.hello?.role === "operator");
  await until("the state is there", (r) => r.store.snapshot !== null);
  await press("robocell resume");
  await until("the button resumes", noFlag(PAUSED));
}

/** Names that look like tags are listed and drawn, and nothing of them is run. */
async function names({ page, look, until, same }) {
  const known = await look((r) => ({
    objects: r.store.scene.objects.map(({ name }) => name),
    arm: r.store.scene.arms[0].name,
  }));
  const tags = known.objects.filter((name) => name.includes("<"));
  same("how many names are tags", tags.length, 2);
  const drawn = await look((r) => Object.keys(r.view.bodyPositions()));
  same("bodies that are drawn", drawn.sort(), [...known.objects].sort());
  for (const name of [...tags, known.arm]) {
    const row = page.locator(".tree-row .name").getByText(name, { exact: true });
    await row.click();
    await until(`${name} is selected`, (r, name) => r.view.selection.name === name, name);
  }
  // Every panel speaks of them.
  await page.getByLabel("names").check();
  for (const tab of await page.getByRole("tab").all()) {
    await tab.click();
    await page.waitForTimeout(200);
  }
  const made = await page.evaluate(() => ({
    owned: "owned" in window,
    images: document.querySelectorAll("img, svg[onload]").length,
    scripts: [...document.scripts].filter(({ text }) => text.includes("owned")).length,
  }));
  same("what was made of the names", made, { owned: false, images: 0, scripts: 0 });
}

/** The robots' real meshes, where the user fetched them. */
async function meshes({ page, look, until, same }) {
  const wanted = await look((r) =>
    r.store.scene.arms.flatMap(({ robot, meshes }) => meshes.map((link) => `${robot}/${link}`)),
  );
  if (wanted.length === 0) throw new Error("no mesh was fetched: `robocell assets fetch`");
  const came = new Set();
  page.on("response", (response) => {
    const path = new URL(response.url()).pathname.match(/^\/meshes\/(.+)\.glb$/);
    if (path !== null && response.ok()) came.add(path[1]);
  });
  await page.reload();
  await until("the page shows the cell", (r) => r?.settled());
  for (const since = Date.now(); came.size < new Set(wanted).size && Date.now() - since < 60_000; ) {
    await page.waitForTimeout(50);
  }
  same("meshes that came", [...came].sort(), [...new Set(wanted)].sort());
  await until("they are drawn", (r) => {
    let drawn = 0;
    r.view.cell.root.traverse(({ userData }) => {
      if (userData.coarse === false) drawn += 1;
    });
    return drawn === r.store.scene.arms.flatMap(({ meshes }) => meshes).length;
  });
}

/** How often a picture is drawn while the cell moves, once the ladder has settled, and the time of scripts for each. */
async function frames({ page, look, until, robocell }) {
  // The shortest job takes half a minute, and a cell at rest is not drawn again.
  const [SETTLE_S, MEASURE_S] = [8, 12];
  await page.setViewportSize({ width: 1280, height: 800 });
  const devtools = await page.context().newCDPSession(page);
  // Processor time: beside the cell on the same cores, a script that waits for one takes twice as long.
  await devtools.send("Performance.enable", { timeDomain: "threadTicks" });
  const scriptS = async () =>
    (await devtools.send("Performance.getMetrics")).metrics.find(({ name }) => name === "ScriptDuration").value;
  await page.mouse.move(0, 0);
  robocell("resume");
  await until("the cell moves", noFlag(PAUSED));
  if (await look((r) => r.store.scene.start_event)) robocell("task", "start");
  await page.waitForTimeout(1000 * SETTLE_S);
  await look((r) => {
    window.updates = 0;
    r.store.on("graph", () => (window.updates += 1));
    // What a picture costs, without messages and panels, which come at rates of their own.
    window.inPictures = 0;
    const ask = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) =>
      ask((time) => {
        const began = performance.now();
        draw(time);
        window.inPictures += performance.now() - began;
      });
  });
  const now = () =>
    look((r) => ({
      inPictures: window.inPictures,
      pictures: r.view.pictures,
      at: performance.now(),
      time: r.store.snapshot.time,
      level: r.view.quality.level.name,
      updates: window.updates,
    }));
  const [first, scriptBefore] = [await now(), await scriptS()];
  await page.waitForTimeout(1000 * MEASURE_S);
  const [last, scriptAfter] = [await now(), await scriptS()];
  if (last.pictures === first.pictures) return "nothing moved";
  const scriptMs = (1000 * (scriptAfter - scriptBefore)) / (last.pictures - first.pictures);
  const drawMs = (last.inPictures - first.inPictures) / (last.pictures - first.pictures);
  const seconds = (last.at - first.at) / 1000;
  const rate = (last.pictures - first.pictures) / seconds;
  const factor = (last.time - first.time) / seconds;
  const size = await look((r) => r.view.screen.size.join("x"));
  const level = first.level === last.level ? last.level : `${first.level}, then ${last.level}`;
  const nodes = await look((r) => r.store.graphs.reduce((sum, graph) => sum + graph.nodes.length, 0));
  const updates = `${((last.updates - first.updates) / seconds).toFixed(1)} updates a second of ${nodes} nodes`;
  return `${rate.toFixed(1)} pictures a second of ${size}, ${level}; scripts ${scriptMs.toFixed(1)} ms of processor time a picture, with messages and panels; drawing ${drawMs.toFixed(1)} ms by the clock; ${updates}; ${factor.toFixed(2)} times real time`;
}

export const scenarios = {
  meshes,
  draws,
  drag,
  gizmo,
  buttons,
  crashes,
  scrub,
  plots,
  viewer,
  names,
  manual,
  flip,
  pallet,
  bins,
  windows,
  keyboard,
  frames,
  lanes,
  speed,
  filter,
  replaySpeed,
  earlier,
  outline,
  largeTree,
  drawing,
  guards,
  breakpoints,
  breakspots,
  policy,
  saved,
  code,
  inspector,
  joints,
  ticks,
  answers,
  jobDrawing,
  load,
  targets,
  guide,
  views,
  sharp,
  reach,
  scenes,
  jog,
  grasp,
  hands,
  status,
  told,
  recorded,
  levels,
  readable,
  phone,
};
