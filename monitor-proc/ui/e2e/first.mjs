// What a person meets in the first minute: the guide, named views, a sharp picture, reach.

/** The card is there, is closed by a person, stays closed, comes back, and is in no picture. */
export async function guide({ page, look, until, same }) {
  const card = page.locator(".guide-card");
  const opener = page.getByRole("button", { name: "Guide", exact: true });
  const reload = async (hash = "") => {
    await page.evaluate((hash) => history.replaceState(null, "", hash === "" ? location.pathname : hash), hash);
    await page.reload();
    await until("the page shows the cell", (r) => r?.settled());
  };
  await page.setViewportSize({ width: 1600, height: 1000 });
  await card.waitFor();
  const demo = await look((r) => r.store.scene.demo);
  const commands = await card.locator("code").allInnerTexts();
  if (commands.length < 3) throw new Error(`things to try: ${commands}`);
  for (const command of commands) if (!command.startsWith("robocell ")) throw new Error(`not a command: ${command}`);
  // A cell of this run has a name of its own where it is not the usual one.
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await card
    .getByRole("button", { name: /^Copy / })
    .first()
    .click();
  await page.locator(".toast", { hasText: "copied" }).waitFor();
  same("the clipboard", await page.evaluate(() => navigator.clipboard.readText()), commands[0]);
  // A panel over the view takes no click meant for it, and the view none meant for the card.
  await look((r) => r.view.select(r.store.scene.arms[0].name));
  await card.locator("h2").click();
  same("the selection", await look((r) => r.view.selection.name), await look((r) => r.store.scene.arms[0].name));
  await page.keyboard.press("Escape");
  await card.waitFor({ state: "hidden" });
  await reload();
  await opener.waitFor();
  same("whether a reload shows what was closed", await card.isVisible(), false);
  await opener.click();
  await card.waitFor();
  await reload();
  await card.waitFor();
  await card.getByRole("button", { name: "Close the guide" }).click();
  await opener.click();
  /** The cell is framed beside the card, or below it. */
  const uncovered = async (isBeside) => {
    const { x, y, width, height } = await card.boundingBox();
    const arm = await look((r) => r.store.scene.arms[0].name);
    for (const name of ["tool", arm]) {
      const [axis, edge] = isBeside ? [0, x + width] : [1, y + height];
      await until(`the card does not cover ${name}`, (r, [name, axis, edge]) => r.view.screenOf(name)[axis] > edge, [
        name,
        axis,
        edge,
      ]);
    }
  };
  await uncovered(true);
  // One line where there is no room for more.
  await page.setViewportSize({ width: 390, height: 844 });
  await card.waitFor();
  const { height, width } = await card.boundingBox();
  if (height > 40 || width > 390) throw new Error(`the card is ${width} x ${height} px`);
  await uncovered(false);
  await card.getByRole("button", { name: "Try" }).click();
  await card.locator("ol").waitFor();
  await card.getByRole("button", { name: "Try" }).click();
  await page.setViewportSize({ width: 1280, height: 720 });
  for (const hash of ["#shot", "#quality=0"]) {
    await reload(hash);
    same(`cards in a picture of ${demo} at ${hash}`, await page.locator(".guide-card, .guide-opener").count(), 0);
  }
}

/** An address names a view, alone and with a moment; a hand that turns it changes the address. */
export async function views({ page, look, until, same }) {
  /** Unit vector from the target of the camera to the eye. */
  const direction = () =>
    look((r) => {
      const { position } = r.view.eye.lens;
      const { target } = r.view.eye.orbit;
      return position.clone().sub(target).normalize().toArray();
    });
  const open = async (hash) => {
    await page.evaluate((hash) => history.replaceState(null, "", location.pathname + hash), hash);
    await page.reload();
    await until("the page shows the cell", (r) => r?.settled());
  };
  const hash = () => page.evaluate(() => location.hash);
  const facing = async (what, axis, sign) => {
    const found = await direction();
    if (sign * found[axis] < 0.9) throw new Error(`${what} looks from ${found}`);
  };
  await open("");
  const cell = await direction();
  await open("#view=top");
  await facing("top", 2, 1);
  await open("#view=front");
  await facing("front", 0, 1);
  await open("#view=side");
  await facing("side", 1, -1);
  // The whole cell stays in the picture of another window.
  await page.setViewportSize({ width: 800, height: 600 });
  await until("the view has the new size", (r) => r.view.screen.canvas.clientWidth === 800);
  await facing("side in a small window", 1, -1);
  await page.setViewportSize({ width: 1280, height: 720 });
  await open("#view=cell");
  same(
    "the view of the cell",
    (await direction()).map((x) => x.toFixed(3)),
    cell.map((x) => x.toFixed(3)),
  );
  await open("#view=nonsense");
  same(
    "the view of an unknown name",
    (await direction()).map((x) => x.toFixed(3)),
    cell.map((x) => x.toFixed(3)),
  );
  // With a moment of the past.
  await until("five seconds are recorded", (r) => r.store.timeline?.to_s > 5);
  await open("#t=2.5&view=top");
  await facing("top in the past", 2, 1);
  same("the moment", await look((r) => Math.abs(r.store.snapshot.time - 2.5) < 0.1), true);
  const kept = new URLSearchParams((await hash()).slice(1));
  same("what the address keeps", [Number(kept.get("t")), kept.get("view")], [2.5, "top"]);
  // The keys name views as the address does.
  await page.keyboard.press("3");
  await facing("key 3", 0, 1);
  same("the view in the address", new URLSearchParams((await hash()).slice(1)).get("view"), "front");
  const frame = await page.locator("#view").boundingBox();
  const [x, y] = [frame.x + frame.width / 2, frame.y + 30];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 80, y + 10, { steps: 4 });
  await page.mouse.up();
  await until("the turned view is in the address", () => /cam=/.test(location.hash) && !/view=/.test(location.hash));
}

/** A cell at rest is drawn once, at the screen's full resolution and with shadows, and
 * not again until something changes, whatever was given up while it moved. */
export async function sharp({ page, look, until, same, robocell }) {
  const AT_REST = `(r) => r.view.picture === "full, at rest"`;
  const full = async (when) => {
    const { buffer, screen, shadows, perPixel } = await look((r) => {
      const gl = r.view.screen.renderer.getContext();
      const { clientWidth, clientHeight } = document.getElementById("view");
      return {
        buffer: [gl.drawingBufferWidth, gl.drawingBufferHeight],
        screen: [clientWidth, clientHeight].map((px) => Math.floor(px * devicePixelRatio)),
        shadows: r.view.screen.renderer.shadowMap.enabled,
        perPixel: r.view.screen.isSoftware ? 2 : 1,
      };
    });
    // Without a graphics card two by two points are drawn for each pixel.
    same(
      `the drawing buffer ${when}`,
      buffer,
      screen.map((px) => px * perPixel),
    );
    same(`shadows ${when}`, shadows, true);
  };
  const small = (r) => r.view.screen.canvas.width < 0.6 * document.getElementById("view").clientWidth;
  // What a process reports first may change the picture.
  await until("every process works", (r) => r.store.status?.processes.every(({ state }) => state === "running"));
  await until("the paused cell is drawn at rest", AT_REST);
  await full("of a paused cell");
  // Ten reports of the monitor later there is no further picture.
  await page.evaluate(() => {
    window.reports = 0;
    window.robocell.store.on("status", () => (window.reports += 1));
  });
  const pictures = await look((r) => {
    const { frames } = r.view;
    const ask = frames.ask.bind(frames);
    window.asked = [];
    frames.ask = () => {
      window.asked.push(new Error().stack);
      ask();
    };
    return r.view.pictures;
  });
  await until("ten reports came", () => window.reports >= 10);
  const more = (await look((r) => r.view.pictures)) - pictures;
  const askedBy = more === 0 ? "" : await page.evaluate(() => window.asked.join("\n"));
  same(`pictures of a cell at rest ${askedBy}`, more, 0);
  // As on a slow machine: the last resort while it moves.
  await look((r) => r.view.quality.go(99));
  robocell("resume");
  if (await look((r) => r.store.scene.start_event)) robocell("task", "start");
  await until("it is drawn with fewer pixels while it moves", small);
  robocell("pause");
  await until("it is drawn at rest again", AT_REST);
  await full("after it moved");
  // A hand on the camera is motion, too.
  const before = await look((r) => r.view.pictures);
  const frame = await page.locator("#view").boundingBox();
  await page.mouse.move(frame.x + 40, frame.y + frame.height - 40);
  await page.mouse.down();
  await page.mouse.move(frame.x + 80, frame.y + frame.height - 50, { steps: 3 });
  await page.mouse.up();
  // One while it turned at least, and the one at rest.
  await until(
    "it is drawn at rest once more",
    `(r, before) => r.view.pictures >= before + 2 && (${AT_REST})(r)`,
    before,
  );
  await full("after it was turned");
}

/** The handles of the target are in the picture, and its label covers neither them nor the border. */
const TARGET_IS_WHOLE = `(r) => {
  const view = document.getElementById("view").getBoundingClientRect();
  const handles = r.view.gizmo.area(view.width, view.height);
  const label = [...document.querySelectorAll("#view .label.number")].find((node) => /mm away/.test(node.textContent) && node.checkVisibility());
  if (handles === null || label === undefined) return false;
  const box = label.getBoundingClientRect();
  const [left, right, top, bottom] = [box.left - view.left, box.right - view.left, box.top - view.top, box.bottom - view.top];
  const isWhole = handles.left >= 0 && handles.right <= view.width && handles.top >= 0 && handles.bottom <= view.height;
  const hasMargin = left > 7 && right < view.width - 7 && top > 7 && bottom < view.height - 7;
  return isWhole && hasMargin && (right < handles.left || left > handles.right || bottom < handles.top || top > handles.bottom);
}`;

/** The panel of reach: its targets lead the arm as their commands do, and it says what comes of them. */
export async function reach({ page, look, until, near, same, robocell }) {
  await page.getByRole("tab", { name: "Reach" }).click();
  const panel = page.locator(".demo-tab");
  const verdict = (text) => panel.locator(".badge", { hasText: text }).waitFor();
  const shown = async (name) => panel.locator(".row", { hasText: name }).locator("b.num").innerText();
  const button = (name) => panel.getByRole("button", { name });
  const command = async (name) => {
    const title = await button(name).getAttribute("title");
    return title.match(/\$ robocell (target .*)/)[1].split(" ");
  };
  const tool = () => look((r) => r.store.snapshot.arms[0].tcp.slice(0, 3));
  await button("In front").click();
  const front = (await command("In front")).slice(1, 4).map(Number);
  await until(
    "the target is the button's",
    (r, at) => at.every((x, axis) => Math.abs(r.store.snapshot.arms[0].target[axis] - x) < 1e-3),
    front,
  );
  await verdict("reached");
  await page.locator("#status .detail", { hasText: /^at the target · FOLLOW$/ }).waitFor();
  near("the tool", await tool(), front, 0.01);
  // A recording has no handles: the mark alone tells the target from the tool.
  same(
    "the mark of the target is drawn",
    await look((r) => r.view.stage.scene.getObjectByName("target mark")?.parent.visible),
    true,
  );
  same("the distance is in mm", /^\d+\.\d mm$/.test(await shown("Distance to the target")), true);
  same("the clearance", await shown("Clearance to obstacles"), "no obstacle");
  const low = await command("Low, to the side");
  robocell(...low);
  await verdict("reached");
  near("the tool after the command", await tool(), low.slice(1, 4).map(Number), 0.01);
  await button("Out of reach").click();
  await verdict("unreachable");
  const bar = page.locator('#status[data-tone="bad"]');
  await bar.locator(".state", { hasText: /^Not reached$/ }).waitFor();
  await bar.locator(".detail", { hasText: /^\d+ mm away: unreachable · FOLLOW$/ }).waitFor();
  await page.locator('.marks [data-mark="hand_failed"][title*="target not reached"]').waitFor({ state: "attached" });
  // Target and label are in the picture of a small window.
  for (const [width, height] of [
    [1600, 1000],
    [390, 844],
  ]) {
    await page.setViewportSize({ width, height });
    await until(`target and label are whole at ${width} pixels`, TARGET_IS_WHOLE);
  }
  await page.setViewportSize({ width: 1024, height: 768 });
  await until("the label of the target is in the picture", (r) => {
    const view = document.getElementById("view").getBoundingClientRect();
    const label = [...document.querySelectorAll("#view .label.number")].find(
      (node) => /mm away/.test(node.textContent) && node.checkVisibility(),
    );
    const box = label?.getBoundingClientRect();
    const [x, y] = r.view.screenOf("gizmo") ?? [-1, -1];
    const isInside = (left, top, right, bottom) =>
      left >= view.left && right <= view.right && top >= view.top && bottom <= view.bottom;
    return box !== undefined && isInside(box.left, box.top, box.right, box.bottom) && isInside(x, y, x, y);
  });
  await page.setViewportSize({ width: 1280, height: 720 });
  const away = Number.parseFloat(await shown("Distance to the target"));
  if (!(away > 100)) throw new Error(`out of reach and ${away} mm away`);
  await bar.getByRole("button", { name: "Target to the tool" }).click();
  await page.locator("#status .detail", { hasText: /^at the target/ }).waitFor();
  await button("In front").click();
  await verdict("reached");
}

/** What a scene calls things by, as far as these are no everyday words. */
const NAMES = `(r) => [
  ...r.store.scene.objects.map(({ name }) => name),
  ...r.store.graphs.flatMap(({ nodes }) => nodes.map(({ name }) => name)),
].filter((name) => /_/.test(name) || /^[A-Z]{5,}$/.test(name))`;
const PANELS = {
  "franka-stack": "Stack",
  "franka-pyramid": "Pyramid",
  reach: "Reach",
  "ur10-palletize": "Pallet",
  "ur10-fill-bin": "Fill bin",
  "ur10-bin-stack": "Stack",
};

/** From demo to demo on one page: each has its own card and panel, and nothing of those before. */
export async function scenes({ page, look, until, same, robocell, forgive, press }) {
  const [titles, seen] = [new Set(), new Set()];
  for (const demo of [...Object.keys(PANELS).slice(1), "franka-stack"]) {
    for (const name of await look(NAMES)) seen.add(name);
    await page.locator(".scene-open").click();
    await page.selectOption("select.demo", demo);
    await press(`robocell load ${demo}`);
    await until(
      `${demo} is there`,
      (r, demo) =>
        r.store.scene?.demo === demo &&
        r.store.connected &&
        r.store.snapshot?.objects.length === r.store.scene.objects.length &&
        r.store.snapshot.arms.length === r.store.scene.arms.length,
      demo,
    );
    robocell("step", "20");
    await until(
      "the task shows itself",
      (r) =>
        r.store.snapshot.tick >= 20 &&
        (r.store.scene.demo === "reach" || r.store.graphs.some(({ nodes }) => nodes.length > 1)),
    );
    const card = page.locator(".guide-card");
    await card.waitFor();
    const title = await card.locator("h2").innerText();
    if (titles.has(title)) throw new Error(`the card of ${demo} is that of another: ${title}`);
    titles.add(title);
    const names = await look((r) => r.store.scene.objects.map(({ name }) => name));
    same(
      `objects in the list of ${demo}`,
      await page.locator(".scene-tree details", { hasText: "Objects" }).locator(".tree-row .name").allInnerTexts(),
      names,
    );
    same(`what is drawn of ${demo}`, await look((r) => r.view.cell.scene.demo), demo);
    const own = new Set(await look(NAMES));
    const stale = [...seen].filter((name) => !own.has(name));
    const tabs = page.getByRole("tab");
    same(`the panel of ${demo}`, await tabs.last().innerText(), PANELS[demo]);
    for (let tab = 0; tab < (await tabs.count()); tab++) {
      await tabs.nth(tab).click();
      const text = await page.locator("#right").innerText();
      const found = stale.filter((name) => new RegExp(`(^|\\W)${name}(\\W|$)`).test(text));
      if (found.length > 0) throw new Error(`the panels of ${demo} still name ${found.join(", ")}`);
    }
    await tabs.first().click();
  }
  forgive(/WebSocket connection to|ERR_CONNECTION_REFUSED/);
}
