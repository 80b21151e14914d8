// Breakpoints of the task, and the editor of its policy.
import { accessible, loadAxe } from "./axe.mjs";
import { flag, noFlag, PAUSED } from "./flags.mjs";

const DECISION_TICKS = 10;

/** A breakpoint is set by a key, pauses the cell, and is removed by a button. */
export async function breakpoints(test) {
  const { page, look, until, press, robocell, same } = test;
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
  await loadAxe(page);
  const tree = page.locator(".graph-pane");
  await tree.getByRole("treeitem", { name: /\bTransport\b/ }).focus();
  await page.keyboard.press("b");
  await page.locator(".break-list li", { hasText: "Transport" }).waitFor();
  same("the cell's breakpoints", JSON.parse(robocell("break", "--json")).breakpoints, ["Transport"]);
  robocell("resume");
  await until("it was reached", (r) => r.store.status.pause_cause === "breakpoint");
  await page.locator(".break-banner", { hasText: "At breakpoint Transport" }).waitFor();
  await page.locator(".time .cause", { hasText: "Transport was reached" }).waitFor();
  await tree.locator(".tree-node.reached .name", { hasText: /^Transport$/ }).waitFor();
  await accessible(page, "a breakpoint that was reached");
  if (process.env.PAGE_SHOT) await page.screenshot({ path: `${process.env.PAGE_SHOT}-break.png` });
  // Decision by decision: also from a tick that is none.
  const before = (await look((r) => r.store.snapshot.tick)) + 3;
  robocell("step", "3");
  // The snapshot too: the status may be newer.
  await until(
    "it stepped",
    (r, tick) => r.store.status.pause_cause === "step" && r.store.snapshot.tick === tick,
    before,
  );
  await page.getByRole("button", { name: "Next decision" }).click();
  const next = before - (before % DECISION_TICKS) + DECISION_TICKS;
  await until(
    "the next decision",
    (r, next) => r.store.snapshot.tick === next && (r.store.snapshot.flags & 1) !== 0,
    next,
  );
  await page.getByRole("button", { name: "Next decision" }).click();
  await until("the one after", (r, next) => r.store.snapshot.tick === next, next + DECISION_TICKS);
  await page.getByRole("button", { name: "Continue", exact: true }).click();
  await until("it continues", noFlag(PAUSED));
  await page.locator(".break-banner").waitFor({ state: "hidden" });
  // What the command line sets is seen, in another page, too.
  robocell("break", "Lower");
  await page.reload();
  await page.locator(".break-list li", { hasText: "Lower" }).waitFor();
  await until("that one was reached", flag(PAUSED));
  await page.locator(".break-banner", { hasText: "At breakpoint Lower" }).waitFor();
  for (const name of ["Transport", "Lower"]) await press(`robocell break --remove ${name}`);
  await page.locator(".breaks").waitFor({ state: "hidden" });
  same("the cell's breakpoints", JSON.parse(robocell("break", "--json")).breakpoints, []);
}

/** A breakpoint of a state and one of a guard, by the mouse. */
export async function breakspots(test) {
  const { page, until, robocell } = test;
  robocell("task", "start");
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
  await page.locator('.graph-pane .state [data-break="ATTACH"]').click();
  await page.locator(".break-list li", { hasText: "ATTACH" }).waitFor();
  await until("the state was reached", (r) => r.store.status.pause_detail === "ATTACH");
  await page.locator(".graph-pane .state.reached").waitFor();
  await page.locator('.graph-pane .state [data-break="ATTACH"]').click();
  await page.locator(".breaks").waitFor({ state: "hidden" });
  await page.setViewportSize({ width: 1600, height: 900 });
  // The keyboard gets to a guard's place, too.
  await page.locator('.value-row [data-break="START"]').focus();
  await page.keyboard.press("Enter");
  await page.locator(".break-list li", { hasText: "START" }).waitFor();
}

const generation = (r) => r.store.status.processes.find(({ name }) => name === "task").generation;
const restarted = (r, before) => r.store.status.processes.find(({ name }) => name === "task").generation > before;
const editor = (page) => page.locator("dialog.policy-sheet .cm-content");

/** The tree of the arm in the title is shown; the end of one arm is no end of the task; many lanes fit, or say that more follow. */
async function severalArms({ page, look, same }) {
  for (const arm of ["LEFT", "RIGHT"]) {
    await page.waitForFunction((arm) => {
      const shown = document.querySelector('.graph-choice [aria-pressed="true"]').textContent.toUpperCase();
      return shown === arm && document.querySelector(".summary .phase").textContent.startsWith(`${arm} `);
    }, arm);
  }
  await page.locator(".lanes-button").click();
  await look((r) => {
    const { time: time_s } = r.store.snapshot;
    const { epoch } = r.store.lanes.at(-1);
    r.store.takeText({ t: "log", lines: [{ time_s, kind: "log", text: "[done] left", mark: "done", epoch }] });
    const span = (lane) => ({ lane, kind: "process", from_s: time_s - 0.5, epoch, label: "restarted", tone: "bad" });
    r.store.takeText({ t: "lanes", all: false, spans: ["one", "two", "three", "four", "five"].map(span) });
  });
  await page.locator('.marks [data-mark="part"]').first().waitFor({ state: "attached" });
  same("marks of the end of the task", await page.locator('.marks [data-mark="done"]').count(), 0);
  await page.locator(".lanes-more", { hasText: /^▾ \d more$/ }).waitFor();
  await page.locator(".lanes-button").click();
}

/** The policy's file is edited, checked and applied. */
export async function policy(test) {
  const { page, look, until, same } = test;
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
  await severalArms(test);
  await loadAxe(page);
  const open = page.getByRole("button", { name: "Edit policy" });
  await open.focus();
  await page.keyboard.press("Enter");
  await editor(page).waitFor();
  const sheet = page.locator("dialog.policy-sheet");
  await sheet.locator(".policy-state", { hasText: "No errors" }).waitFor();
  await sheet.getByText("not saved: run with --data").waitFor();
  await accessible(page, "the editor");
  // A mistake is told at its place.
  await page.keyboard.press("Control+Home");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("End");
  await page.keyboard.type("!");
  const told = sheet.locator(".policy-mistakes button").first();
  await told.waitFor();
  same("where it is", (await told.innerText()).match(/^(\d+):/)[1], "2");
  await sheet.locator(".cm-lint-marker-error").waitFor();
  await accessible(page, "the editor with a mistake");
  if (process.env.PAGE_SHOT) await page.screenshot({ path: `${process.env.PAGE_SHOT}-policy.png` });
  same("Apply is off", await sheet.getByRole("button", { name: "Apply" }).getAttribute("aria-disabled"), "true");
  // Escape asks before the changes are lost, also twice.
  for (let times = 0; times < 2; times++) {
    await page.keyboard.press("Escape");
    await sheet.getByText("The changes are not applied.").waitFor();
    await page.keyboard.press("Escape");
    await sheet.getByText("The changes are not applied.").waitFor({ state: "hidden" });
  }
  await page.keyboard.press("Backspace");
  await sheet.locator(".policy-state", { hasText: "No errors" }).waitFor();
  // The applied text runs, and is the one that the editor opens next.
  const before = await look(generation);
  await rename(page, "franka-pyramid", "my-pyramid");
  await sheet.locator(".policy-state", { hasText: "No errors" }).waitFor();
  await sheet.getByRole("button", { name: "Apply" }).click();
  await sheet.locator(".policy-state", { hasText: "the task restarts" }).waitFor();
  await until("the task restarted", restarted, before);
  await page.keyboard.press("Escape");
  await sheet.waitFor({ state: "detached" });
  same("the focus is back", await open.evaluate((node) => node === document.activeElement), true);
  await page.keyboard.press("Enter");
  await editor(page).waitFor();
  if (!(await editor(page).innerText()).includes("my-pyramid"))
    throw new Error("the applied text is not what is edited next");
  await page.keyboard.press("Escape");
}

/** Replaces the first `from` of the text by the keyboard. */
async function rename(page, from, to) {
  const field = page.locator("dialog.policy-sheet .cm-search input[name=search]");
  await editor(page).focus();
  await page.keyboard.press("Control+Home");
  await page.keyboard.press("Control+f");
  await field.waitFor();
  await page.keyboard.type(from);
  await page.keyboard.press("Enter");
  await page.keyboard.press("Escape");
  await page.keyboard.type(to);
}

/** With a folder of data, an applied text is saved, and the page names the file. */
export async function saved(test) {
  const { page, look, until } = test;
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
  const before = await look(generation);
  await page.getByRole("button", { name: "Edit policy" }).click();
  const sheet = page.locator("dialog.policy-sheet");
  await sheet.getByText("Applied texts are saved to").waitFor();
  await editor(page).waitFor();
  await rename(page, "franka-pyramid", "my-pyramid");
  await sheet.locator(".policy-state", { hasText: "No errors" }).waitFor();
  await sheet.getByRole("button", { name: "Apply" }).click();
  await sheet.locator(".policy-state", { hasText: /Applied and saved to .*franka-pyramid\.tree\.json/ }).waitFor();
  await until("the task restarted", restarted, before);
}

/** A policy of code has no file: the button says so. */
export async function code({ page, until }) {
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
  const open = page.getByRole("button", { name: "Edit policy" });
  await open.hover();
  await page.locator('button[aria-disabled="true"][title*="written in code"]', { hasText: "Edit policy" }).waitFor();
}
