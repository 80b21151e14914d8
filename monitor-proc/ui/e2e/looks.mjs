// Texts and drawings can be read, and the picture shows nothing that is not there.
import { existsSync, readFileSync, writeFileSync } from "node:fs";

/** Levels of the quality ladder without shadows. */
const NO_SHADOWS = [4, 5, 6];
const LEVELS = [0, 1, 2, 3, ...NO_SHADOWS];
/** Largest difference of two pictures, of 255: of the median block, and of any block. */
const SAME_TONE = 4;
const SAME_BLOCK = 10;

/** The picture as it is drawn now, as the brightness of 32 x 18 blocks. */
async function blocks({ page, look }) {
  await page.waitForTimeout(300);
  return look((r) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [32, 18];
    const brush = canvas.getContext("2d");
    brush.imageSmoothingQuality = "high";
    // Drawn and copied at once: the browser keeps no picture of a finished frame.
    r.view.pixels();
    brush.drawImage(r.view.screen.canvas, 0, 0, 32, 18);
    const { data } = brush.getImageData(0, 0, 32, 18);
    return Array.from({ length: 32 * 18 }, (_, at) => (data[4 * at] + data[4 * at + 1] + data[4 * at + 2]) / 3);
  });
}

/**
 * Compares the blocks of each level with the reference of the demo, `levels/DEMO.txt`: per level 18 lines of 32
 * brightnesses in hexadecimal. With PAGE_REFERENCE=write the file is written instead.
 */
function compare(demo, found) {
  const file = new URL(`levels/${demo}.txt`, import.meta.url);
  const text = [...found].map(([level, all]) => {
    const rows = Array.from({ length: 18 }, (_, row) =>
      Buffer.from(all.slice(32 * row, 32 * row + 32).map(Math.round)).toString("hex"),
    );
    return `level ${level}\n${rows.join("\n")}\n`;
  });
  if (process.env.PAGE_REFERENCE === "write") return writeFileSync(file, text.join(""));
  if (!existsSync(file)) throw new Error(`${demo} has no reference picture; PAGE_REFERENCE=write makes it`);
  const known = readFileSync(file, "utf8")
    .split(/level \d\n/)
    .slice(1)
    .map((rows) => [...Buffer.from(rows.replaceAll("\n", ""), "hex")]);
  for (const [at, [level, all]] of [...found].entries()) {
    const worst = differences(all, known[at]).at(-1);
    if (!(worst <= SAME_BLOCK))
      throw new Error(`level ${level} of ${demo} differs by ${worst.toFixed(1)} of 255 from its reference`);
  }
}

function differences(one, other) {
  return one.map((value, at) => Math.abs(value - other[at])).sort((a, b) => a - b);
}

/** Every level of quality has the tones of the best one, and no shadow of an earlier picture. */
export async function levels(test) {
  const { page, look, until, robocell } = test;
  const use = (level) =>
    look((r, level) => {
      r.view.quality.fixed = true;
      r.view.quality.go(level);
    }, level);
  await until("the cell is drawn", (r) => r.view.pictures > 2);
  const found = new Map();
  for (const level of LEVELS) {
    await use(level);
    found.set(level, await blocks(test));
  }
  compare(await look((r) => r.store.scene.demo), found);
  for (const level of LEVELS) {
    const all = differences(found.get(level), found.get(0));
    const median = all[Math.floor(all.length / 2)];
    if (median > SAME_TONE)
      throw new Error(`the tones of level ${level} are ${median.toFixed(1)} from those of level 0`);
  }
  // The arm moves while shadows are drawn; the levels without them must not keep one.
  await use(2);
  robocell("step", "1500");
  await until("the cell was stepped", (r) => r.store.snapshot.tick >= 1500);
  const later = new Map();
  for (const level of NO_SHADOWS) {
    await use(2);
    await blocks(test);
    await use(level);
    later.set(level, await blocks(test));
  }
  // From where it is seen now: the whole cell is framed by where the arm was when the page was opened.
  const camera = await look((r) => r.view.eye.numbers());
  for (const level of NO_SHADOWS) {
    await page.goto("about:blank");
    await page.goto(`${test.home}#quality=${level}&cam=${camera}`);
    await until("the page is there again", (r) => r !== undefined && r.view.pictures > 2 && r.store.snapshot !== null);
    const all = differences(later.get(level), await blocks(test));
    const worst = all.at(-1);
    if (worst > SAME_BLOCK)
      throw new Error(
        `level ${level} after one with shadows differs by ${worst.toFixed(1)} from a page that never had any`,
      );
  }
}

/** The row of the active state is in the visible part of the table, also after the next phases. */
async function rowInView({ page, look, until }) {
  const away = () =>
    look(() => {
      const row = document.querySelector('.live-table tr[data-status="R"]');
      if (row === null) return 0;
      const [inner, outer, head] = [row, row.closest(".table-box"), row.closest("table").tHead].map((node) =>
        node.getBoundingClientRect(),
      );
      return Math.max(outer.top + head.height - inner.top, inner.bottom - outer.bottom, 0);
    });
  for (let phase = 0; phase < 3; phase++) {
    const before = await look((r) => r.store.letters[0]);
    await until("the next phase begins", (r, before) => r.store.letters[0] !== before, before);
    let px = await away();
    for (const since = Date.now(); px > 1 && Date.now() - since < 2000; px = await away())
      await page.waitForTimeout(100);
    if (px > 1) throw new Error(`the row of the active state is ${px} px out of the table`);
    // No row is cut by the header, where the table was scrolled for the active one.
    const cut = await look(() => {
      const head = document.querySelector(".live-table").tHead.getBoundingClientRect().bottom;
      return [...document.querySelectorAll(".live-table tbody tr")]
        .map((row) => row.getBoundingClientRect())
        .some(({ top, bottom }) => top < head - 2 && bottom > head + 2);
    });
    if (cut) throw new Error("the header of the table cuts a row");
  }
}

/** Texts of the task at first sight, explanations of terms, and the timeline by wheel and keys. */
export async function readable({ page, look, until, same, robocell }) {
  robocell("resume");
  const active = page.locator('.machine .state[data-status="R"]:not(.holds) text').first();
  await active.waitFor();
  await until(
    "a phase has passed",
    (r) => r.store.lanes.filter(({ kind, label }) => kind === "phase" && label !== "").length >= 3,
  );
  const seen = await look(() => {
    const text = document.querySelector('.machine .state[data-status="R"]:not(.holds) text');
    const view = document.querySelector(".viewport").getBoundingClientRect();
    const box = text.getBoundingClientRect();
    const scale = text.getScreenCTM().a;
    const inside = box.left >= view.left && box.right <= view.right && box.top >= view.top && box.bottom <= view.bottom;
    const table = [...document.querySelectorAll(".live-table td")].map((cell) =>
      parseFloat(getComputedStyle(cell).fontSize),
    );
    return { px: scale * parseFloat(getComputedStyle(text).fontSize), inside, table: Math.min(...table) };
  });
  if (!(seen.px >= 11 && seen.table >= 11))
    throw new Error(`texts of ${seen.px} px in the graph and ${seen.table} px in the table`);
  same("the active state is in view", seen.inside, true);
  const [drawing, buttons] = [
    await page.locator(".viewport .drawing").boundingBox(),
    await page.locator(".viewport .zoom-buttons").boundingBox(),
  ];
  if (drawing.x + drawing.width > buttons.x + 1) throw new Error("the zoom buttons lie over the drawing");
  await rowInView({ page, look, until });
  const note = page.locator("#term-note");
  const term = page.locator('.term[data-term="resyncs"]');
  await term.hover();
  await page.locator("#term-note", { hasText: "began again" }).waitFor();
  await page.mouse.move(5, 400);
  await note.waitFor({ state: "hidden" });
  await term.focus();
  await note.waitFor();
  await page.keyboard.press("Escape");
  await note.waitFor({ state: "hidden" });
  robocell("pause");
  const bar = page.locator(".time-track .bar");
  const box = await bar.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const length = async () =>
    Number(await bar.getAttribute("aria-valuemax")) - Number(await bar.getAttribute("aria-valuemin"));
  const whole = await length();
  await page.mouse.wheel(0, -400);
  await until(
    "the wheel zooms",
    (_r, whole) => {
      const node = document.querySelector(".time-track .bar");
      return node.ariaValueMax - node.ariaValueMin < 0.7 * whole;
    },
    whole,
  );
  await page.getByRole("button", { name: "All", exact: true }).click();
  await until(
    "all is shown again",
    (_r, whole) => {
      const node = document.querySelector(".time-track .bar");
      return node.ariaValueMax - node.ariaValueMin >= whole - 0.01;
    },
    whole,
  );
  robocell("restart", "controller");
  await until("the restart is marked", (r) => r.store.marked.some(({ mark }) => mark === "restart"));
  robocell("step", "500");
  await page.locator("#view").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("[");
  await until("the mark before is shown", (r) => (r.store.snapshot.flags & 16) !== 0);
}

/** A phone: state and phase are in view, the time can be chosen, and a finger that stays on a cube pulls it. */
export async function phone({ page, look, until, robocell }) {
  await page.setViewportSize({ width: 390, height: 844 });
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Emulation.setTouchEmulationEnabled", { enabled: true });
  const touch = (type, ...points) =>
    devtools.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  robocell("resume");
  await page.locator("#status .state", { hasText: "Running" }).waitFor();
  // The objects are not lost in a picture of the whole table: the camera is as near as the arms and the work allow.
  const apart_px = await look((r) => {
    const [one, other] = ["red_cube", "yellow_cube"].map((name) => r.view.screenOf(name));
    const [from, to] = ["red_cube", "yellow_cube"].map((name) => r.view.bodyPositions()[name]);
    return Math.hypot(one[0] - other[0], one[1] - other[1]) / Math.hypot(...from.map((x, axis) => x - to[axis]));
  });
  if (apart_px < 250) throw new Error(`a metre of the table has ${apart_px} px`);
  // The last one that the task takes.
  const name = "yellow_cube";
  const index = await look((r, name) => r.store.scene.objects.findIndex((one) => one.name === name), name);
  const before = await look((r, i) => r.store.snapshot.objects[i].pose.slice(0, 3), index);
  const [x, y] = await look((r, name) => r.view.screenOf(name), name);
  await touch("touchStart", [x, y]);
  await page.waitForTimeout(800);
  for (let step = 1; step <= 10; step++) {
    await touch("touchMove", [x, y + 3 * step]);
    await page.waitForTimeout(60);
  }
  await page
    .locator(".label", { hasText: /^\d+ mm to / })
    .first()
    .waitFor();
  await until(
    "the finger moved the cube",
    (r, [i, before]) =>
      Math.hypot(...[0, 1].map((axis) => r.store.snapshot.objects[i].pose[axis] - before[axis])) > 0.03,
    [index, before],
  );
  await touch("touchEnd");
  robocell("pause");
  const box = await page.locator(".time-track .bar").boundingBox();
  if (box.width < 100) throw new Error(`the timeline is ${box.width} px wide`);
  await touch("touchStart", [box.x + 5, box.y + box.height / 2]);
  await touch("touchEnd");
  await page.locator("#status .state", { hasText: "Past" }).waitFor();
  const overlap = await look(() => {
    const [time, bar] = [".now", ".time-track"].map((at) =>
      document.querySelector(`#bottom ${at}`).getBoundingClientRect(),
    );
    return time.right > bar.left + 1 && time.bottom > bar.top + 1 && time.top < bar.bottom - 1;
  });
  if (overlap) throw new Error("the time covers the timeline");
}
