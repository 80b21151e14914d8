// What a person does with time: lanes, the past at any speed, the speed of a cell.
import { flag, NOT_LIVE, noFlag, PAUSED } from "./flags.mjs";

const time = (look) => look((r) => r.store.snapshot.time);

/** Lanes tell phases, grips and restarts; a click looks at that moment; the past plays. */
export async function lanes({ page, look, until, robocell, press, same }) {
  await page.setViewportSize({ width: 1600, height: 900 });
  const fold = page.getByRole("button", { name: "Lanes" });
  if ((await fold.getAttribute("aria-expanded")) !== "true") await fold.click();
  await press("robocell resume");
  await until("a cube was carried", (r) => r.store.status.task.placed.length > 0);
  robocell("restart", "controller");
  await until("the restart has a lane", (r) =>
    r.store.lanes.some(({ kind, lane, label }) => kind === "process" && lane === "controller-0" && label !== ""),
  );
  robocell("pause");
  await until("paused", flag(PAUSED));
  for (const lane of ["outcome", "phase", "grip", "controller-0"]) {
    await page.locator(`.lane[data-lane="${lane}"] i`).first().waitFor({ state: "attached" });
  }
  await alignedAndColoured({ page, look, same });
  await newestLine({ page, look });
  await resetsAndMarks({ page, look, until, same });
  const held = await look((r) => r.store.lanes.find(({ lane, label }) => lane === "grip" && label !== ""));
  same("what was held", held.label, "red_cube");
  const carried = page.locator('.lane[data-lane="grip"] i').first();
  const box = await carried.boundingBox();
  await page.mouse.click(box.x + 0.6 * box.width, box.y + 5);
  await until("the past is shown", flag(NOT_LIVE));
  await until("the cube is in the hand then", (r) => r.store.snapshot.arms[0].held === 0);

  const before = await time(look);
  // Slowly: it must not end before a range is chosen.
  await page.getByLabel("Speed of the past").selectOption("0.5");
  await page.locator(".playback").getByRole("button", { name: "Play" }).click();
  await until("the past is played", (r, before) => r.store.snapshot.time > before + 0.2, before);
  // A range that is looped is never left.
  const bar = await page.locator("#bottom .bar").boundingBox();
  await page.keyboard.down("Shift");
  await page.mouse.move(bar.x + 0.2 * bar.width, bar.y + 10);
  await page.mouse.down();
  await page.mouse.move(bar.x + 0.3 * bar.width, bar.y + 10, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const [from, to] = await look((r) => {
    const { from_s, to_s } = r.store.timeline;
    return [from_s + 0.2 * (to_s - from_s), from_s + 0.3 * (to_s - from_s)];
  });
  const inside = (r, [from, to]) => r.store.snapshot.time >= from - 0.2 && r.store.snapshot.time <= to + 0.2;
  await until("the range is played", inside, [from, to]);
  const seen = new Set();
  for (let look_at = 0; look_at < 20; look_at++) {
    await page.waitForTimeout(100);
    seen.add(Math.round(10 * (await time(look))));
    if (!(await look(inside, [from, to]))) throw new Error(`the loop was left for ${await time(look)} s`);
  }
  if (seen.size < 3) throw new Error("the loop does not play");
  await page.getByRole("button", { name: "Back to live" }).click();
  await until("now is shown", noFlag(NOT_LIVE));
}

/** Lanes are where the bar is, and a phase has the colour of its name, unlike its neighbours. */
async function alignedAndColoured({ page, look, same }) {
  const box = (at) => page.locator(at).boundingBox();
  const [bar, area] = [await box("#bottom .bar"), await box(".lane-area")];
  same("left edge and width of the lanes", [area.x, area.width].map(Math.round), [bar.x, bar.width].map(Math.round));
  const centre = (box) => box.x + box.width / 2;
  const [knob, line] = [await box("#bottom .cursor"), await box(".lane-cursor")];
  if (Math.abs(centre(knob) - centre(line)) > 1.5)
    throw new Error(`the time is at ${centre(knob)} px of the bar and at ${centre(line)} px of the lanes`);
  const colours = () =>
    look(() =>
      [...document.querySelectorAll('.lane i[data-kind="phase"]')].map((node) => [
        node.title.split("\n")[0],
        getComputedStyle(node).backgroundColor,
      ]),
    );
  const seen = await colours();
  for (const [at, [name, colour]] of seen.entries()) {
    const [next, other] = seen[at + 1] ?? [name, ""];
    if (next !== name && colour === other) throw new Error(`${name} and ${next} have one colour`);
  }
  const byName = new Map(seen);
  for (const [name, colour] of seen) same(`the colour of ${name}`, colour, byName.get(name));
}

/** A reset that no state tells of cuts the lanes, has a row and a mark; marks of one moment are beside each other. */
async function resetsAndMarks({ page, look, until, same }) {
  const times = await look((r) => {
    const { epoch } = r.store.log.at(-1);
    const time_s = r.store.snapshot.time - 0.5;
    const [one, other] = r.store.spans.filter(({ kind }) => kind === "phase").map(({ from_s }) => from_s + 0.2);
    const resets = [one, other].map((at_s) => ({
      time_s: at_s,
      kind: "lifecycle",
      text: "[task] reset",
      mark: null,
      epoch,
    }));
    const marks = ["fault", "hand", "recover"].map((mark) => ({
      time_s,
      kind: "log",
      text: `one moment: ${mark}`,
      mark,
      epoch,
    }));
    r.store.takeText({ t: "log", lines: [...resets, ...marks] });
    return [one, other];
  });
  const cut = (r, times) =>
    times.every((at_s) =>
      ["task", "phase"].every((kind) => r.store.spans.some((span) => span.kind === kind && span.from_s === at_s)),
    );
  await until("the lanes are cut at the resets", cut, times);
  await page.locator('.marks [data-mark="reset"]').nth(1).waitFor({ state: "attached" });
  // The list shows a line with its next update.
  await page.locator('.event[data-mark="reset"]').nth(1).waitFor({ state: "attached" });
  same("rows of resets", await page.locator('.event[data-mark="reset"]').count(), 2);
  await page.locator('.marks [title*="one moment"]').nth(2).waitFor({ state: "attached" });
  const at = await look(() =>
    [...document.querySelectorAll('.marks [title*="one moment"]')]
      .map((node) => node.getBoundingClientRect().x)
      .sort((a, b) => a - b),
  );
  if (at.some((x, index) => index > 0 && x - at[index - 1] < 12))
    throw new Error(`marks of one moment cover each other: ${at}`);
  const beyond = await look(() => {
    const { right } = document.querySelector(".lane-area").getBoundingClientRect();
    return [...document.querySelectorAll(".lane i")]
      .filter((node) => node.getBoundingClientRect().right > right + 0.6)
      .map(({ title }) => title);
  });
  same("spans beyond the end of the lanes", beyond, []);
}

/** The list of events is at its newest line. */
async function newestLine({ page, look }) {
  const away = () =>
    look(() => {
      const list = document.querySelector(".event-list");
      return list.scrollHeight - list.clientHeight - list.scrollTop;
    });
  for (const since = Date.now(); (await away()) > 2 && Date.now() - since < 5000; ) await page.waitForTimeout(100);
  if ((await away()) > 2) throw new Error(`the newest event is ${await away()} px below the list`);
  const order = await look((r) => {
    const line = { kind: "log", mark: null, ...r.store.log.at(-1) };
    for (const [later_s, text] of [
      [0.3, "told first"],
      [0.1, "told late"],
    ])
      r.store.takeText({ t: "log", lines: [{ ...line, time_s: line.time_s + later_s, text }] });
    return r.store.log.map(({ text }) => text).filter((text) => text.startsWith("told "));
  });
  if (order[0] !== "told late") throw new Error(`the order of lines: ${order}`);
  const isWhole = () =>
    look(() => {
      const list = document.querySelector(".event-list");
      const top = list.getBoundingClientRect().top;
      const cut = [...list.children]
        .map((row) => row.getBoundingClientRect())
        .find((row) => row.top < top - 1 && row.bottom > top + 1);
      return cut === undefined || cut.bottom - top > list.clientHeight / 2;
    });
  for (const since = Date.now(); !(await isWhole()) && Date.now() - since < 5000; ) await page.waitForTimeout(50);
  if (!(await isWhole())) throw new Error("the first line in sight is cut");
  await page.locator(".event-list").hover();
  await page.mouse.wheel(0, -200);
  await page.waitForTimeout(1000);
  if ((await away()) < 100) throw new Error("the list does not stay where it was scrolled to");
  await page.mouse.wheel(0, 5000);
  await page.waitForTimeout(500);
}

/** The speed of a running cell is changed at once, here and on the command line. */
export async function speed({ page, look, until, robocell, press }) {
  await page.setViewportSize({ width: 1600, height: 900 });
  await press("robocell resume");
  const select = page.getByLabel("Speed", { exact: true });
  await select.selectOption("0.1");
  await until("the cell runs slowly", (r) => r.store.status.speed === "0.1" && r.store.snapshot.realTimeFactor < 0.3);
  robocell("speed", "1");
  await until("the command shows", (r) => r.store.status.speed === "1");
  const shown = () => select.inputValue();
  for (const since = Date.now(); (await shown()) !== "1" && Date.now() - since < 20_000; )
    await page.waitForTimeout(100);
  if ((await shown()) !== "1") throw new Error(`the page shows speed ${await shown()}`);
  if ((await look((r) => r.store.hello.run.demo)) !== "franka-stack") throw new Error("another scene");
  const pending = await page.getByRole("button", { name: "Create scene *" }).count();
  if (pending !== 0) throw new Error("a speed that is in force is marked as not applied");
}

/** A warning that is told again and again, in turn with another one, has one row with its count. */
async function repeated({ page, look, same }) {
  await look((r) => {
    const { epoch } = r.store.log.at(-1);
    const lines = [1, 2, 3].flatMap((time_s) =>
      ["left", "right"].map((arm) => ({
        time_s,
        kind: "log",
        text: `[warning] ${arm}: nothing is free`,
        mark: null,
        epoch,
      })),
    );
    r.store.takeText({ t: "log", lines });
  });
  const rows = page.locator('.event[data-tone="warn"]', { hasText: "nothing is free" });
  await rows.first().waitFor();
  same(
    "rows of two warnings",
    await rows.allInnerTexts().then((all) => all.map((text) => text.split(/\s+/).join(" "))),
    ["left", "right"].map((arm) => `3.00 [warning] ${arm}: nothing is free ×3`),
  );
}

/** Kinds of lines are hidden and shown, and how many are hidden is said. */
export async function filter({ page, look, same, until, robocell, press }) {
  await press("robocell resume");
  robocell("pause");
  await until("the operator is in the log", (r) => r.store.log.some(({ text }) => text.startsWith("operator:")));
  const shown = page.locator(".event-list .event", { hasText: "operator:" });
  await shown.first().waitFor();
  const colours = await shown.evaluateAll((nodes) => [
    ...new Set(nodes.map((node) => getComputedStyle(node).borderLeftColor)),
  ]);
  same("colours of what an operator did", colours, ["rgb(58, 71, 85)"]);
  await repeated({ page, look, same });
  await page.locator(".event-bar").getByRole("button", { name: "operator" }).click();
  await shown.first().waitFor({ state: "detached" });
  await page.getByText(/\d+ hidden/).waitFor();
  await page.reload();
  await until("the page is back", (r) => r !== undefined && r.store.log.length > 0);
  if ((await shown.count()) > 0) throw new Error("the filter was forgotten");
}

/** The speed and the loop of a recording. */
export async function replaySpeed({ page, look, until, same }) {
  await page.setViewportSize({ width: 1600, height: 900 });
  const rate = async () => {
    const [before, since] = [await time(look), Date.now()];
    await page.waitForTimeout(1500);
    return (1000 * ((await time(look)) - before)) / (Date.now() - since);
  };
  const play = page.locator("#bottom .live");
  await page.getByLabel("Speed", { exact: true }).selectOption("0.1");
  if (await look((r) => (r.store.snapshot.flags & 1) !== 0)) await play.click();
  await until("it plays", noFlag(PAUSED));
  const slow = await rate();
  await page.getByLabel("Speed", { exact: true }).selectOption("0.5");
  await page.waitForTimeout(300);
  const fast = await rate();
  if (!(fast > 2 * slow)) throw new Error(`${slow} s/s at 0.1 and ${fast} s/s at 0.5`);
  // Its end is followed by its beginning.
  await page.locator(".playback").getByRole("button", { name: "Loop" }).click();
  const to = await look((r) => r.store.timeline.to_s);
  await page.evaluate((time_s) => window.robocell.store.command({ do: "seek", time_s, play: true }), to - 0.3);
  await until("it was near its end", (r, to) => r.store.snapshot.time > to - 0.5, to);
  await until("it plays again from the beginning", (r, to) => r.store.snapshot.time < to / 2, to);
  if (await look((r) => (r.store.snapshot.flags & 1) !== 0)) throw new Error("a loop is paused at its beginning");
  await play.click();
  await until("it is paused", flag(PAUSED));
  // The keys of the bar step through it.
  const at = await time(look);
  await page.locator("#bottom .bar").focus();
  await page.keyboard.press("ArrowRight");
  await until("a tenth later", (r, at) => Math.abs(r.store.snapshot.time - at - 0.1) < 0.06, at);
  // The first states are older than the first one of the objects.
  same("what was wrong in a good run", await look((r) => r.store.wrong), []);
}

/** The moment of the past that is looked at outlives its run: `--loop` starts the next seed meanwhile. */
export async function earlier({ page, look, until, same, near, forgive }) {
  const bar = page.locator("#status");
  const look_at = async (time_s) => {
    const { ok, message } = await page.evaluate(
      (time_s) => window.robocell.store.command({ do: "seek", time_s }),
      time_s,
    );
    if (!ok) throw new Error(`a look at ${time_s} s: ${message}`);
    await until(
      `${time_s} s are shown`,
      (r, time_s) => (r.store.snapshot.flags & 16) !== 0 && Math.abs(r.store.snapshot.time - time_s) < 0.1,
      time_s,
    );
  };
  const seen = () =>
    look((r) => ({
      time: r.store.snapshot.time,
      phase: r.store.status.task.phase,
      letters: r.store.letters[0],
      tool: r.store.snapshot.arms[0].tcp.slice(0, 3),
    }));
  // A slow page sees the end of the first run.
  await until("some seconds of a run are recorded", (r) => r.store.timeline?.to_s > 4 && r.store.timeline.to_s < 8);
  const seed = await look((r) => r.store.hello.run.seed);
  await look_at(3);
  const then = await seen();
  await until("the next run has begun", (r) => r.store.earlier !== null);
  same("the moment", await seen(), then);
  await bar
    .locator(".detail", { hasText: new RegExp(`^${then.time.toFixed(2)} s of seed ${seed}, whose run has ended$`) })
    .waitFor();
  const tab = page.locator("#right .tab-panel:not([hidden]) > *").first();
  same("whether the task of then is shown", await tab.isVisible(), true);
  // Of other moments of that run the page has the state of physics.
  await look_at(7);
  if (Math.hypot(...(await seen()).tool.map((x, axis) => x - then.tool[axis])) < 0.01)
    throw new Error("the arm has not moved");
  near("the tool that is drawn", await look((r) => r.view.tool().toArray()), (await seen()).tool, 3e-3);
  await tab.waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Back to live" }).click();
  await until(
    "now is shown",
    (r, seed) => r.store.connected && r.store.hello.run.seed !== seed && (r.store.snapshot.flags & 16) === 0,
    seed,
  );
  await tab.waitFor();
  const outcome = page.locator(".episode-list i", { hasText: String(seed) });
  same("the outcome of that seed", /^Seed \d+: done, \d/.test(await outcome.first().getAttribute("title")), true);
  forgive(/WebSocket connection to|ERR_CONNECTION_REFUSED/);
}
