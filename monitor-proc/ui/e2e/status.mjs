// The bar above the 3D view and the title of the window: the activity of the cell, its faults, its end.

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
  if (!/^[a-z ]{5,} · out of the cell: yellow_cube$/.test(reason))
    throw new Error(`the reason of the failure: ${reason}`);
  await press("Look at the moment");
  await state("Past · failed");
  const failed_s = await look(
    (r) => r.store.lanes.filter(({ kind, label }) => kind === "task" && label === "failed").at(-1).from_s,
  );
  const shown_s = await look((r) => r.store.snapshot.time);
  if (Math.abs(failed_s - shown_s) > 0.05) throw new Error(`failed at ${failed_s} s, shown is ${shown_s} s`);
  await page.getByRole("button", { name: "Back to live" }).click();
  await state("Failed");
  await press("Run again");
  await state("Running");
  robocell("down");
  await state("The cell has ended");
  await endedLooksEnded(page, look, same);
  await titled("The cell has ended");
  same("what starts it again", await bar.locator("code").innerText(), await look((r) => r.store.hello.run.command));
  same(
    "the command of a person",
    await look((r) => r.store.hello.run.command.startsWith("robocell run franka-stack ")),
    true,
  );
  same(
    "the colour of a process that has ended",
    await look(() => getComputedStyle(document.querySelector(".process .dot")).backgroundColor),
    "rgb(149, 163, 179)",
  );
  forgive(/WebSocket connection to|ERR_CONNECTION_REFUSED/);
}

/** Nothing that was a number of now is left, nothing pulses, and the bar says how the task was. */
async function endedLooksEnded(page, look, same) {
  await page
    .locator("#status .detail", { hasText: /^at \d\d:\d\d:\d\d · the task was running · [A-Z_ ]+ · / })
    .waitFor();
  await page.locator(".summary .badge", { hasText: /^ended: running$/ }).waitFor();
  await page.locator(".badges .badge", { hasText: /^ended$/ }).waitFor();
  const left = await look(() => {
    const shown = (at) =>
      [...document.querySelectorAll(at)].filter((node) => node.checkVisibility()).map((node) => node.textContent);
    return {
      factor: shown(".factor"),
      rates: [...new Set(shown(".process .head .num:first-of-type"))],
      decision: shown(".summary .num:not(b)"),
      live: shown("#bottom .live"),
    };
  });
  same("what was live", left, { factor: ["ended"], rates: ["ended"], decision: [], live: ["Ended"] });
  same(
    "what pulses",
    await look(
      () => document.getAnimations().filter((one) => one instanceof CSSAnimation && one.playState === "running").length,
    ),
    0,
  );
  same("icons of what would pause", await page.locator('[data-icon="pause"]').count(), 0);
  await page.locator('#bottom .live[aria-disabled="true"] [data-icon="stop"]').waitFor();
  same(
    "greyscale of what tells objects apart",
    await look(() =>
      ["#view", "#left"].filter((at) =>
        /grayscale|saturate\(0?\.[0-2]/.test(getComputedStyle(document.querySelector(at)).filter),
      ),
    ),
    [],
  );
  same("green badges", await page.locator('.badge[data-tone="ok"]:visible').count(), 0);
  const edges = await look(() => {
    const [bar, said, command] = ["#status", "#status .said", "#status .command"].map((at) =>
      document.querySelector(at).getBoundingClientRect(),
    );
    return [said.top - bar.top, bar.bottom - command.bottom].map(Math.round);
  });
  if (edges.some((px) => px < 6 || px > 14)) throw new Error(`above and below the text of the bar are ${edges} px`);
  await page.setViewportSize({ width: 1024, height: 768 });
  const tops = await look(() =>
    ["#top .drawer-buttons", "#top [aria-label=Help]"].map(
      (at) => document.querySelector(at).getBoundingClientRect().bottom,
    ),
  );
  if (Math.abs(tops[0] - tops[1]) > 8) throw new Error(`the bar on top has two lines at 1024 px: ${tops}`);
}

/** A recorded run in which the task and physics were killed: its incidents, lanes and faults are shown from the start. */
export async function recorded({ page, until, same, look }) {
  const bar = page.locator("#status");
  await bar.locator(".state", { hasText: /^Replay$/ }).waitFor();
  await bar.locator(".detail", { hasText: "2 incidents" }).waitFor();
  await until("the lanes say when a process was not running", (r) =>
    ["task", "physics"].every((name) =>
      r.store.lanes.some(({ lane, label }) => lane === name && label === `${name} was killed by the script`),
    ),
  );
  await page.locator('.marks [data-mark="incident"]').first().click();
  const sheet = page.locator("dialog.incident");
  await sheet.locator(".incident-summary li").first().waitFor();
  const sentences = await sheet.locator(".incident-summary li").allInnerTexts();
  for (const said of [
    /^At \d+\.\d\d s task was killed by the script\.$/,
    /^task works again after \d+ ms\.$/,
    /^panda /,
    /dropped/,
  ]) {
    if (!sentences.some((sentence) => said.test(sentence)))
      throw new Error(`no sentence ${said} in: ${sentences.join(" ")}`);
  }
  await sheet.getByRole("button", { name: "Look at this moment" }).click();
  const at_s = Number(sentences[0].match(/At ([\d.]+) s/)[1]);
  await until("the moment of the failure is shown", (r, at_s) => Math.abs(r.store.snapshot.time - at_s) < 0.02, at_s);
  same("the sheet", await sheet.count(), 0);
  await page.locator(".event", { hasText: "incident 1: task was killed by the script" }).waitFor();
  same("lines of what comes later", await look((r) => r.store.log.filter(({ incident }) => incident === 2).length), 0);
  // Of its end the bar says so, and the cursor is on the bar.
  await page.evaluate(() => window.robocell.store.command({ do: "seek", time_s: window.robocell.store.timeline.to_s }));
  await bar.locator(".detail", { hasText: /^[A-Z_ ]+ · .*the recording ends here · / }).waitFor();
  await page.locator("#bottom .cursor").waitFor();
  await page.locator(".summary .badge", { hasText: /^replay: running$/ }).waitFor();
  same("badges of who may command a recording", await page.locator(".badge.role:visible").count(), 0);
  await page.locator('button[aria-disabled="true"]', { hasText: "Edit policy" }).waitFor();
}

/** A short loss of the connection is one state with one word, and no end. */
async function shortLoss({ page, look, same }) {
  const lose = (connected) =>
    look((r, connected) => {
      r.store.connected = connected;
      r.store.heard_ms = Date.now();
      r.store.emit("connection", connected);
    }, connected);
  /** What the places of the page say, in the same moment as the change. */
  const said = (connected) =>
    look((r, connected) => {
      r.store.connected = connected;
      r.store.heard_ms = Date.now();
      r.store.emit("connection", connected);
      const all = [
        "#status .state",
        ".badges .badge[role=status]",
        ".summary .badge",
        "#bottom .live",
        ".factor",
        ".process .num",
      ].map((at) => document.querySelector(at).textContent);
      return { all, green: document.querySelectorAll('.badge[data-tone="ok"], #status[data-tone="ok"]').length };
    }, connected);
  const without = await said(false);
  same(
    "places that do not say that there is no answer",
    without.all.filter((text) => !/^no answer/i.test(text)),
    [],
  );
  same("green places without an answer", without.green, 0);
  same(
    "places that say that there is no answer, when there is one",
    (await said(true)).all.filter((text) => /^no answer/i.test(text)),
    [],
  );
  await lose(false);
  for (const [at, text] of [
    ["#status .state", /^No answer$/],
    [".badges .badge", /^no answer$/],
    [".summary .badge", /^no answer: /],
    ["#bottom .live", /^No answer$/],
    [".factor", /^no answer$/],
  ]) {
    await page.locator(at, { hasText: text }).first().waitFor({ timeout: 4000 });
  }
  await page.locator("body.stale").waitFor();
  await page.locator('.lane[data-lane="outcome"] i', { hasText: /^object lost$/ }).waitFor();
  await lose(true);
  await page.locator("body:not(.stale)").waitFor();
}

/** A fault while a task runs that does not know of it; before, the list says that it has no events yet. */
export async function told({ page, robocell, look, until, same }) {
  const bar = page.locator("#status");
  await page.locator(".no-event", { hasText: /^No event yet\.$/ }).waitFor();
  await page.locator(".lanes-button").click();
  robocell("resume");
  await bar.locator(".state", { hasText: /^Running$/ }).waitFor();
  robocell("drag", "cube", "--to", "1.5", "0", "0.6");
  await bar.locator(".state", { hasText: /^Object lost$/ }).waitFor();
  await bar.locator(".detail", { hasText: /^cube · / }).waitFor();
  await page.locator('#status[data-tone="bad"]').waitFor();
  await bar.getByRole("button", { name: "Reset", exact: true }).waitFor();
  await page.locator('.process .dot[data-tone="warn"]').waitFor();
  await page.locator(".lost-list .tree-row", { hasText: "cube" }).waitFor();
  // What no process tells of is an event and a mark.
  for (const [text, mark] of [
    [/by hand: cube is pulled$/, "hand"],
    [/object lost: cube fell out of the cell$/, "drop"],
  ]) {
    await page.locator(".event", { hasText: text }).waitFor();
    await page.locator(`.marks [data-mark="${mark}"]`).first().waitFor({ state: "attached" });
  }
  await lasts({ page, until });
  robocell("pause");
  await bar.locator(".state", { hasText: /^Paused · object lost$/ }).waitFor();
  await page.locator(".badges .badge", { hasText: /^paused$/ }).waitFor();
  same(
    "green badges of a paused cell",
    await page.locator('.badges .badge[data-tone="ok"]:not(.role):visible').count(),
    0,
  );
  await page.locator(".event", { hasText: /operator: pause$/ }).waitFor();
  await page.locator("#bottom .live", { hasText: /^Paused$/ }).waitFor();
  await page
    .locator(".process .num", { hasText: /^paused$/ })
    .first()
    .waitFor();
  await shortLoss({ page, look, same });
  // A page that is opened later knows what was recorded.
  await page.reload();
  await page
    .locator(".event", { hasText: /object lost: cube/ })
    .first()
    .waitFor();
  await page.locator('.marks [data-mark="drop"]').first().waitFor({ state: "attached" });
  robocell("reset");
  robocell("resume");
  await done({ page, robocell, look, same });
}

/** A state that lasts has one word everywhere, and its mark also in a window that starts later. */
async function lasts({ page, until }) {
  await page.locator(".summary .badge", { hasText: /^object lost$/ }).waitFor();
  await page.locator('.lane[data-lane="outcome"] i[data-tone="bad"]', { hasText: /^object lost$/ }).waitFor();
  await page.waitForFunction(() => document.title.startsWith("Object lost: "));
  await until(
    "some seconds have passed since",
    (r) => r.store.snapshot.time > r.store.marked.find(({ mark }) => mark === "drop").time_s + 3,
  );
  const box = await page.locator(".time-track .bar").boundingBox();
  await page.mouse.move(box.x + box.width - 1, box.y + box.height / 2);
  await page.mouse.wheel(0, -1500);
  await page
    .locator(".marks .before", { hasText: "‹" })
    .locator('[data-mark="drop"][title*=" s  object lost"]')
    .first()
    .waitFor({ state: "attached" });
  await page.getByRole("button", { name: "All", exact: true }).click();
}

/** The end of a task that says nothing of it: mark, event, phase, graph and table. */
async function done({ page, robocell, look, same }) {
  await page.locator('#status[data-tone="done"] .state', { hasText: /^Done$/ }).waitFor();
  await page.locator(".summary .badge", { hasText: /^done$/ }).waitFor();
  await page.locator('.marks [data-mark="done"]').waitFor({ state: "attached" });
  await page.locator('.event[data-mark="done"]').waitFor();
  await page.locator('.lane[data-lane="phase"] i', { hasText: /^done$/ }).waitFor();
  await page.locator(".state-span", { hasText: /^done$/ }).waitFor({ state: "attached" });
  await page.locator('.machine .state[data-status="S"]').waitFor();
  const ways = await look(() =>
    [
      document.querySelector(".live-table tr.last td:nth-child(2)"),
      document.querySelector('.machine .state[data-status="S"] text'),
    ].map((node) => node.textContent),
  );
  same("where the last transition leads", ways[0], `→ ${ways[1]}`);
  same(
    "the place of the cube is drawn",
    await look((r) => r.view.stage.scene.getObjectByName("place mark")?.parent.visible),
    true,
  );
  same(
    "the sign of the end in the graph",
    await page.locator('.machine .state[data-status="S"] .end-sign').first().textContent(),
    "✓",
  );
  await page.locator('.live-table td[data-end="S"]').first().waitFor();
  same(
    "ways that are shown as next after the end",
    await page.locator(".live-table tr[data-status=S], .live-table tr[data-status=R]").count(),
    0,
  );
  robocell("pause");
  await page.locator("#status .state", { hasText: /^Paused · done$/ }).waitFor();
  await page.locator("#status .button.primary:visible", { hasText: "Run again" }).waitFor();
  await page.locator(".task-buttons .button.primary", { hasText: "Run again" }).waitFor();
  await page.locator("#status .button:not(.primary):visible", { hasText: "Play" }).waitFor();
  await page.locator("#top .play:not(.primary)").waitFor();
}
