// What the panels of the bins tell: answers of their buttons, drawings, the load.
import { flag, noFlag, PAUSED, TASK_PAUSED } from "./flags.mjs";

/** Each press of a button of the equipment is answered, in a toast and in the events. */
export async function answers({ page, look, until, press, robocell, same }) {
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await page.getByRole("tab").last().click();
  const toast = (text) => page.locator(".toast", { hasText: text }).first();
  if (await look((r) => r.store.scene.dispenser !== null)) {
    const count = await look((r) => r.store.scene.dispenser.per_drop);
    await press("robocell drop-parts");
    await toast(`Dropped ${count} parts, `).waitFor();
    await inEvents(page, `Dropped ${count} parts`);
    return;
  }
  robocell("reset");
  await until("no bin is here", (r) => r.store.snapshot.objects.every(({ flags }) => (flags & 1) === 0));
  await press("robocell add-bin --flipped");
  await toast("Added bin").waitFor();
  const said = await toast("Added bin").innerText();
  const here = await look((r) =>
    r.store.scene.objects
      .filter((_, index) => (r.store.snapshot.objects[index].flags & 1) !== 0)
      .map(({ name }) => name),
  );
  same("what was added", said.split("\n")[0], `Added ${here[0]}, upside down`);
  await fallen({ page, robocell }, here[0]);
  // The belt takes no more than it has room for.
  const refused = toast("No bin was added: ");
  for (let attempt = 0; attempt < 12 && !(await refused.isVisible()); attempt++) {
    await press("robocell add-bin");
    await page.waitForTimeout(300);
  }
  await refused.waitFor();
  await inEvents(page, "No bin was added: ");
}

/** A bin that fell out of the cell is lost, and not one that waits to come, until a reset. */
async function fallen({ page, robocell }, name) {
  const list = page.locator(".lost-list");
  robocell("drag", name, "--to", "1.6", "-0.6", "0.4");
  await list.locator(".tree-row", { hasText: name }).waitFor();
  await page.locator(`.marks [data-mark="drop"][title*="${name} fell out of the cell"]`).waitFor({ state: "attached" });
  robocell("reset");
  await list.waitFor({ state: "hidden" });
}

async function inEvents(page, text) {
  await page.getByRole("tab", { name: "Task" }).click();
  await page.locator(".event-list", { hasText: text }).waitFor();
}

/** The drawing shows the placed bins and the one in flight, and its label names them. */
export async function drawing({ page, look, until, press, robocell, same }) {
  await press("robocell resume");
  await until("the cell runs", noFlag(PAUSED));
  if (await look((r) => r.store.scene.start_event)) robocell("task", "start");
  await page.getByRole("tab").last().click();
  const drawn = (place) => `document.querySelectorAll('.job-drawing .bin[data-place="${place}"]').length`;
  const label = `(document.querySelector(".job-drawing")?.getAttribute("aria-label") ?? "")`;
  await until("a bin in flight is told", `(r) => ${label}.includes("In flight: bin")`);
  await until("a bin is placed", (r) => r.store.status.task.placed.length > 0);
  robocell("task", "pause");
  await until("the task is paused", flag(TASK_PAUSED));
  const count = await look((r) => r.store.status.task.placed.length);
  await until("as many are drawn", `(r) => ${drawn("placed")} === ${count}`);
  const told = await look(`() => ${label}`);
  const [, filled, all] = told.match(/(\d+) of (\d+) (?:slots|places) are filled/);
  same("how many are filled", [Number(filled), Number(all)], [count, await look((r) => r.store.scene.bins)]);
}

/** The chart shows the load up to the break, also of the past. */
export async function load({ page, look, until, press, robocell, same }) {
  robocell("task", "start");
  await page.getByRole("tab").last().click();
  const chart = `document.querySelector(".load-chart").load`;
  // A cup that only touches an object carries no load.
  await until(
    "the cup touches an object",
    (r) => r.store.snapshot.arms[0].attached || r.store.snapshot.arms[0].held !== null,
  );
  const early = await look(
    (r) =>
      r.store.snapshot.arms[0].held === null &&
      r.view.shown?.arms[0].held == null &&
      document.querySelector("#view .label.load") !== null,
  );
  if (early) throw new Error("a load is written before an object is held");
  await until("the load is written beside the cup", (r) => {
    const label = document.querySelector("#view .label.load");
    if (label === null) return false;
    const [{ left, right, top, bottom }, [x, y]] = [label.getBoundingClientRect(), r.view.screenOf("tool")];
    const gap_px = Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
    return gap_px > 10 && gap_px < 80;
  });
  await until("the grip broke", (r) => r.store.log.some(({ mark }) => mark === "break"));
  await page.locator("#status .state", { hasText: /^Picking up again$/ }).waitFor();
  await page.locator("#status .detail", { hasText: /^[A-Z]+ · grip lost 1 time$/ }).waitFor();
  await page.locator('.marks i[data-mark="break"]').first().waitFor({ state: "attached" });
  await until("the break is marked", `(r) => ${chart}.breaks() > 0`);
  await until("the load rose", `(r) => Math.max(...${chart}.data()[1]) > 30`);
  await pickedUpAgain({ page, look, until, same });
  await press("robocell pause");
  await until("it is paused", flag(PAUSED));
  const at = await look((r) => r.store.log.find(({ mark }) => mark === "break").time_s - 2);
  await page.evaluate(`window.robocell.store.command({ do: "seek", time_s: ${at} })`);
  await until("the past is shown", `(r) => ${chart}.cursor() !== null && Math.abs(${chart}.cursor() - ${at}) < 1`);
  await until("its load is read", `(r) => ${chart}.data()[0].length > 20 && Math.max(...${chart}.data()[1]) > 30`);
  const [from, to] = await look(`() => [${chart}.data()[0][0], ${chart}.data()[0].at(-1)]`);
  if (at < from || at > to) throw new Error(`the chart shows ${from} to ${to} s, not ${at} s`);
}

/** A job that lost its grip after it was done works again, and its end is not told again. */
async function pickedUpAgain({ page, look, until, same }) {
  const bar = page.locator("#status");
  await page.getByRole("tab", { name: "Task" }).click();
  await until("the bar, the badge and the buttons say that it is picked up again", (r) => {
    // A grip that was lost before the end has the same words.
    if (r.store.status.task.outcome !== "done") return false;
    const text = (at) => document.querySelector(at).textContent;
    const isSaid =
      text("#status .state") === "Picking up again" && /^[A-Z]+ · grip lost \d+ times?$/.test(text("#status .detail"));
    const primary = [...document.querySelectorAll(".button.primary")].filter(
      (node) => node.checkVisibility() && node.textContent === "Run again",
    );
    return isSaid && text(".summary .badge") === "picking up again" && primary.length === 0;
  });
  await bar.locator(".state", { hasText: /^Running$/ }).waitFor();
  await bar.locator(".detail", { hasText: /^HOLDING · holds bin · grip lost \d+ times?$/ }).waitFor();
  await until(
    "the phase is that of the work",
    (r) => r.store.spans.filter(({ kind }) => kind === "phase").at(-1).label === "HOLDING",
  );
  const labels = await look((r) => r.store.spans.filter(({ kind }) => kind === "task").map(({ label }) => label));
  same("the outcome", labels.slice(labels.indexOf("done"), labels.indexOf("done") + 3), [
    "done",
    "picking up again",
    "running",
  ]);
  await page.getByRole("tab").last().click();
}
