// The graphs of the task: outline and drawing, ages of guards, states of the last minute.
import { accessible, loadAxe } from "./axe.mjs";

const pane = (page) => page.locator(".graph-pane");

async function isDrawn({ until, robocell, look }) {
  await until("the scene is there", (r) => r?.store.scene != null);
  if (await look((r) => r.store.scene.start_event)) robocell("task", "start");
  await until("the policy is drawn", (r) => r.store.graphs.some(({ nodes }) => nodes.length > 1));
}

/** Where the drawing is: its scale and its origin. */
async function lookOf(page) {
  const world = pane(page).locator(".world[transform]");
  await world.waitFor({ state: "attached" });
  const [x, y, scale] = (await world.getAttribute("transform")).match(/-?[\d.]+/g).map(Number);
  return { x, y, scale };
}

/** Waits until the drawing is elsewhere than `before`; a wheel is not waited for. */
async function moved(page, before) {
  for (;;) {
    const now = await lookOf(page);
    if (JSON.stringify(now) !== JSON.stringify(before)) return now;
    await page.waitForTimeout(50);
  }
}

/** The outline of a tree, by the keyboard. */
export async function outline(test) {
  const { page, until, same } = test;
  await isDrawn(test);
  await until("something runs", (r) => r.store.letters[0]?.includes("R"));
  await loadAxe(page);
  const line = (name) =>
    pane(page)
      .getByRole("treeitem", { name: new RegExp(`\\b${name}\\b`) })
      .first();
  await line("Root").focus();
  await page.keyboard.press("End");
  const last = await page.evaluate(() => document.activeElement.querySelector(".name").textContent);
  same("the end of the tree", last, "ClearHolding");
  await page.keyboard.press("Home");
  // Collapsed, the root tells what runs within it.
  await page.keyboard.press("ArrowLeft");
  same("it is collapsed", await line("Root").getAttribute("aria-expanded"), "false");
  same("lines of the tree", await pane(page).locator(".tree-node:visible").count(), 1);
  await pane(page).locator(".inside", { hasText: "▶" }).waitFor();
  await accessible(page, "the outline, collapsed");
  // Another tab and back, and the drawing: it is still collapsed.
  await page.getByRole("tab", { name: "Robot" }).click();
  await page.getByRole("tab", { name: "Task" }).click();
  same("lines of the tree", await pane(page).locator(".tree-node:visible").count(), 1);
  await pane(page).getByRole("button", { name: "Tree" }).click();
  same("nodes of the drawing", await pane(page).locator(".leaf").count(), 1);
  await pane(page).getByRole("button", { name: "Outline" }).click();
  // A match is expanded, and Enter selects the next one.
  await line("Root").focus();
  await page.keyboard.press("Control+f");
  await page.keyboard.type("lift");
  await page.keyboard.press("Enter");
  same("matches", await pane(page).locator(".find-count").innerText(), "1/2");
  const chosen = () => pane(page).locator('[aria-selected="true"] .name').innerText();
  same("the first match", await chosen(), "LiftBack");
  await page.keyboard.press("Enter");
  same("the second match", await chosen(), "Lift");
  same("lines that are marked", await pane(page).locator(".tree-node.found:visible").count(), 2);
  await accessible(page, "the outline, searched");
  await page.keyboard.press("Escape");
  same("lines that are marked", await pane(page).locator(".tree-node.found").count(), 0);
}

/** A tree of ten thousand nodes: what runs is found at first sight, and any node by its name. */
export async function largeTree(test) {
  const { page, until, same, look } = test;
  await isDrawn(test);
  await until("the whole tree is there", (r) => r.store.graphs[0].nodes.length > 10_000);
  await until("something runs", (r) => r.store.letters[0]?.includes("R"));
  const lines = pane(page).locator(".tree-node:visible");
  const count = await lines.count();
  if (count < 50 || count > 300) throw new Error(`${count} lines are shown at first`);
  await pane(page).locator(".inside", { hasText: "▶ wait" }).first().waitFor();
  // A node that is folded away is found and brought into view.
  await page.getByRole("searchbox", { name: "Find nodes" }).fill("wait 99.96");
  await page.keyboard.press("Enter");
  const chosen = pane(page).locator('[aria-selected="true"]');
  same("the node that was found", await chosen.locator(".name").innerText(), "wait 99.96");
  const [line, body] = [await chosen.boundingBox(), await pane(page).locator(".graph-body").boundingBox()];
  if (line.y < body.y || line.y + line.height > body.y + body.height)
    throw new Error("the node that was found is out of view");
  await page.keyboard.press("Escape");
  // All of it at once.
  await page.evaluate(() => {
    for (const handle of document.querySelectorAll('.graph-pane [aria-expanded="false"] .chevron')) handle.click();
  });
  same("nodes that are shown", await lines.count(), await look((r) => r.store.graphs[0].nodes.length));
  await look((r) => {
    window.updates = 0;
    r.store.on("graph", () => (window.updates += 1));
  });
  await until("it is updated", () => window.updates > 20);
}

/** The drawing of a tree: pan, zoom, fit; it looks the same when it comes again. */
export async function drawing(test) {
  const { page, same, near } = test;
  await isDrawn(test);
  await loadAxe(page);
  await pane(page).getByRole("button", { name: "Tree" }).click();
  await accessible(page, "the drawing");
  const view = pane(page).locator(".viewport");
  const box = await view.boundingBox();
  // What runs is not followed while a person points at the drawing.
  await view.hover({ position: { x: 5, y: 5 } });
  const fitted = await lookOf(page);
  // Its text can be read: what does not fit is beyond the border, and not smaller.
  if (fitted.scale < 1) throw new Error(`the drawing is shown at ${fitted.scale} of its size`);
  // The wheel zooms around the pointer: the point under it stays there.
  // Pointers are at whole pixels of the window.
  const [px, py] = [Math.round(box.x + box.width / 3) - box.x, Math.round(box.y + box.height / 3) - box.y];
  const under = ({ x, y, scale }) => [(px - x) / scale, (py - y) / scale];
  await page.mouse.move(box.x + px, box.y + py);
  await page.mouse.wheel(0, -600);
  const zoomed = await moved(page, fitted);
  if (zoomed.scale < 1.5 * fitted.scale) throw new Error(`the wheel zoomed from ${fitted.scale} to ${zoomed.scale}`);
  near("what is under the pointer", under(zoomed), under(fitted), 0.5);
  // A drag pans, and is no click on a node.
  await page.mouse.down();
  await page.mouse.move(box.x + px + 60, box.y + py + 25, { steps: 5 });
  await page.mouse.up();
  const panned = await lookOf(page);
  near("the drawing", [panned.x, panned.y], [zoomed.x + 60, zoomed.y + 25], 1);
  same("a node's sheet", await page.locator(".task-tab > .node-detail").isVisible(), false);
  // Keys.
  await view.focus();
  await page.keyboard.press("ArrowRight");
  near("the drawing", [(await lookOf(page)).x], [panned.x - 40], 1);
  await page.keyboard.press("+");
  near("the scale", [(await lookOf(page)).scale], [1.25 * panned.scale], 0.01);
  // It survives another tab, a reset of the scene and another way of showing it.
  const kept = await lookOf(page);
  await page.getByRole("tab", { name: "Plots" }).click();
  await page.getByRole("tab", { name: "Task" }).click();
  await pane(page).getByRole("button", { name: "Outline" }).click();
  await pane(page).getByRole("button", { name: "Tree" }).click();
  same("the drawing afterwards", await lookOf(page), kept);
  await page.keyboard.press("Tab");
  await page.getByRole("button", { name: "1:1" }).click();
  same("the scale", (await lookOf(page)).scale, 1);
  await view.focus();
  await page.keyboard.press("0");
  near("the scale", [(await lookOf(page)).scale], [fitted.scale], 0.01);
  await collapses(test);
  await large(test);
  // The choice is kept.
  await page.reload();
  await isDrawn(test);
  await pane(page).locator(".leaf").first().waitFor();
}

/** A handle collapses a subtree, which tells how much is in it. */
async function collapses({ page, same, look }) {
  const all = await look((r) => r.store.graphs[0].nodes.length);
  same("nodes", await pane(page).locator(".leaf").count(), all);
  const leaf = pane(page).locator(".leaf", { has: page.locator("text", { hasText: "StackRecovery" }) });
  // The whole tree at once has small text.
  const view = pane(page).locator(".viewport");
  await view.focus();
  const isWhole = async () => {
    const [box, world] = [await view.boundingBox(), await pane(page).locator(".world").boundingBox()];
    return (
      world.x >= box.x &&
      world.y >= box.y &&
      world.x + world.width <= box.x + box.width &&
      world.y + world.height <= box.y + box.height
    );
  };
  // It shrinks towards the middle, where it is brought first.
  const middle = async () => {
    const [box, world] = [await view.boundingBox(), await pane(page).locator(".world").boundingBox()];
    await page.mouse.move(box.x + 8, box.y + 8);
    await page.mouse.down();
    await page.mouse.move(
      box.x + 8 + box.x + box.width / 2 - world.x - world.width / 2,
      box.y + 8 + box.y + box.height / 2 - world.y - world.height / 2,
      { steps: 4 },
    );
    await page.mouse.up();
  };
  await middle();
  for (let step = 0; step < 12 && !(await isWhole()); step++) await page.keyboard.press("-");
  await leaf.locator(".handle").click();
  const inside = await look(({ store }) => {
    const { nodes } = store.graphs[0];
    const root = nodes.findIndex(({ name }) => name === "StackRecovery");
    return nodes.filter(({ parent }) => parent === root).length;
  });
  same("nodes with one collapsed", await pane(page).locator(".leaf").count(), all - inside);
  same("what is in it", (await leaf.locator(".count").textContent()).trim().split(" ")[0], String(inside));
  await leaf.locator("> text").first().dblclick();
  same("nodes, expanded", await pane(page).locator(".leaf").count(), all);
  await page.locator(".task-tab > .node-detail").getByRole("button", { name: "Close" }).click();
}

/** The same tools in the large one. */
async function large({ page, same }) {
  await page.getByRole("button", { name: "Show the graph large" }).click();
  const dialog = page.locator("dialog.large-graph");
  await dialog.locator(".leaf").first().waitFor();
  await page.keyboard.press("Control+f");
  await page.keyboard.type("transport");
  await dialog.getByRole("button", { name: "1:1" }).click();
  await dialog.getByLabel("Find nodes").press("Enter");
  await dialog.getByLabel("Find nodes").press("Enter");
  const chosen = dialog.locator(".leaf.found.chosen");
  same("the match", (await chosen.locator("> text").textContent()).trim(), "Transport");
  const [box, place] = [await dialog.locator(".viewport").boundingBox(), await chosen.boundingBox()];
  const inside = place.x > box.x && place.x < box.x + box.width && place.y > box.y && place.y < box.y + box.height;
  same("the match is in sight", inside, true);
  await accessible(page, "the large drawing");
  await dialog.getByRole("button", { name: "Close" }).last().click();
  await dialog.waitFor({ state: "detached" });
}

/** What was asked in an earlier state is dim, with its age; the states are a strip. */
export async function guards(test) {
  const { page, until, look, same } = test;
  await isDrawn(test);
  await loadAxe(page);
  await page.setViewportSize({ width: 1600, height: 900 });
  await until("something was attached and placed", (r) => r.store.guards[0]?.ATTACHED && r.store.guards[0]?.DETACHED);
  const read = () =>
    page.evaluate(() =>
      [...document.querySelectorAll(".value-row")].map((row) => ({
        name: row.querySelector(".key").innerText.trim(),
        old: row.classList.contains("old"),
        says: row.querySelector(".held").innerText.replace(/\s+/g, " "),
      })),
    );
  // ATTACHED was asked for the state before, and DETACHED is never asked with it.
  const rows = await read();
  const attached = rows.find(({ name }) => name === "ATTACHED");
  same("ATTACHED is old", attached.old, true);
  if (!/^last true ?[\d.]+ s ago$/.test(attached.says)) throw new Error(`ATTACHED says ${JSON.stringify(attached)}`);
  const current = rows.filter(({ name, old }) => !old && ["ATTACHED", "DETACHED"].includes(name));
  if (current.length > 1) throw new Error(`current at once: ${JSON.stringify(current)}`);
  const age = async () => Number((await read()).find(({ name }) => name === "ATTACHED").says.match(/[\d.]+/)[0]);
  const [before, time] = [await age(), await look((r) => r.store.snapshot.time)];
  await until("two seconds passed", (r, time) => r.store.snapshot.time > time + 2, time);
  const later = await age();
  if (!(later > before + 1 || later < 1)) throw new Error(`ATTACHED was ${before} s old, then ${later} s`);
  // A row that is shown again is no new answer.
  const old = page.locator(".value-row.old", { hasText: "ATTACHED" }).first();
  await page.setViewportSize({ width: 390, height: 844 });
  await old.waitFor({ state: "hidden" });
  await page.setViewportSize({ width: 1600, height: 900 });
  await old.waitFor();
  same("flashes of an old row", await old.evaluate((row) => row.getAnimations().length), 0);
  // The states of the last minute: the last is the active one.
  const states = await page.evaluate(() => {
    const spans = [...document.querySelectorAll(".graph-pane .state-span:not([hidden])")];
    return spans.map((span) => span.textContent);
  });
  const known = await look((r) => r.store.graphs[0].nodes.map(({ name }) => name));
  if (states.length < 4 || states.some((state) => !known.includes(state))) throw new Error(`the strip shows ${states}`);
  await until("the strip ends with the active state", (r) => {
    const spans = [...document.querySelectorAll(".graph-pane .state-span:not([hidden])")];
    return spans.at(-1)?.textContent === r.store.status.task.phase.replaceAll("_", " ");
  });
  await accessible(page, "values and strip");
  // A reload knows the answers, but not when they were given.
  await page.reload();
  await until("the page is back", (r) => r?.settled() && r.store.guards[0]?.ATTACHED);
  await page.locator(".value-row", { hasText: "ATTACHED" }).first().waitFor();
}
