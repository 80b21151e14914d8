// The bar above the 3D view and the title of the window: what the cell does, what is wrong, that it ended.

/** The states of a stacking job one after the other, by the text of the bar alone. */
export async function status({ page, robocell, forgive, look, same }) {
  const bar = page.locator("#status");
  const state = (text) => bar.locator(".state", { hasText: new RegExp(`^${text}$`) }).waitFor();
  const press = (name) => bar.getByRole("button", { name, exact: true }).click();
  const titled = (text) => page.waitForFunction((text) => document.title.startsWith(text), text);
  await state("Paused");
  await press("Play");
  await state("Running");
  await titled("Running: ");
  robocell("task", "pause");
  await state("Task paused");
  await press("Resume Task");
  await state("Running");
  // Off the table: no arm gets it back.
  robocell("drag", "yellow_cube", "--to", "1.5", "0", "0.6");
  await state("Failed");
  const reason = await bar.locator(".detail").innerText();
  if (!/^[a-z ]{5,} · out of the cell: yellow_cube$/.test(reason)) throw new Error(`the reason of the failure: ${reason}`);
  await press("Look at the moment");
  await state("Past");
  const failed_s = await look((r) => r.store.lanes.filter(({ kind, label }) => kind === "task" && label === "failed").at(-1).from_s);
  const shown_s = await look((r) => r.store.snapshot.time);
  if (Math.abs(failed_s - shown_s) > 0.05) throw new Error(`failed at ${failed_s} s, shown is ${shown_s} s`);
  await page.getByRole("button", { name: "Back to live" }).click();
  await state("Failed");
  await press("Run again");
  await state("Running");
  robocell("down");
  await state("The cell has ended");
  await titled("The cell has ended");
  same("what starts it again", await bar.locator("code").innerText(), await look((r) => `robocell run franka-stack --policy ${r.store.hello.run.policy} --seed ${r.store.hello.run.seed}`));
  same("the colour of a process that has ended", await look(() => getComputedStyle(document.querySelector(".process .dot")).backgroundColor), "rgb(149, 163, 179)");
  forgive(/WebSocket connection to|ERR_CONNECTION_REFUSED/);
}

/** A recorded run in which the task and physics were killed: its incidents, lanes and faults are shown from the start. */
export async function recorded({ page, until, same, look }) {
  const bar = page.locator("#status");
  await bar.locator(".state", { hasText: /^Replay$/ }).waitFor();
  await bar.locator(".detail", { hasText: "2 incidents" }).waitFor();
  await until("the lanes say when a process was not running", (r) =>
    ["task", "physics"].every((name) => r.store.lanes.some(({ lane, label }) => lane === name && label === `${name} was killed by the script`)),
  );
  await page.locator('.marks [data-mark="incident"]').first().click();
  const sheet = page.locator("dialog.incident");
  await sheet.locator(".incident-summary li").first().waitFor();
  const sentences = await sheet.locator(".incident-summary li").allInnerTexts();
  for (const said of [/^At \d+\.\d\d s task was killed by the script\.$/, /^task works again after \d+ ms\.$/, /^panda /, /dropped/]) {
    if (!sentences.some((sentence) => said.test(sentence))) throw new Error(`no sentence ${said} in: ${sentences.join(" ")}`);
  }
  await sheet.getByRole("button", { name: "Look at this moment" }).click();
  const at_s = Number(sentences[0].match(/At ([\d.]+) s/)[1]);
  await until("the moment of the failure is shown", (r, at_s) => Math.abs(r.store.snapshot.time - at_s) < 0.02, at_s);
  same("the sheet", await sheet.count(), 0);
  await page.locator(".event", { hasText: "incident 1: task was killed by the script" }).waitFor();
  same("lines of what comes later", await look((r) => r.store.log.filter(({ incident }) => incident === 2).length), 0);
}

/** What is wrong while a task runs that does not know of it, and that there is nothing to list yet. */
export async function told({ page, robocell, press }) {
  const bar = page.locator("#status");
  await page.locator(".no-event", { hasText: /^No event yet\.$/ }).waitFor();
  robocell("resume");
  await bar.locator(".state", { hasText: /^Running$/ }).waitFor();
  robocell("drag", "cube", "--to", "1.5", "0", "0.6");
  await bar.locator(".detail", { hasText: / · out of the cell: cube$/ }).waitFor();
  await page.locator('#status[data-tone="warn"]').waitFor();
  await page.locator('.process .dot[data-tone="warn"]').waitFor();
  await press("robocell pause");
  await page.locator(".no-event").waitFor({ state: "hidden" });
}
