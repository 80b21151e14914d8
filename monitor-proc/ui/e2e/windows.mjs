// The page in windows of every size, and with a screen reader.
import { accessible, loadAxe } from "./axe.mjs";
import { flag, noFlag, PAUSED } from "./flags.mjs";

const SIZES = [
  [1600, 900],
  [1280, 720],
  [800, 600],
  [390, 844],
];
/** A window that is narrower has drawers. */
const DRAWERS_PX = 1100;

/** Nothing is cut, the 3D view has room, drawers open, and axe-core finds nothing serious. */
export async function windows({ page, look, until, robocell, forgive }) {
  await loadAxe(page);
  for (const [width, height] of SIZES) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(300);
    await fits(page, width);
    for (const tab of ["Task", "Robot", "Plots", "Latency"]) {
      if (width < DRAWERS_PX) await page.getByRole("button", { name: "Panels", exact: true }).click();
      await page.getByRole("tab", { name: tab }).click();
      await page.waitForTimeout(300);
      await accessible(page, `${tab} at ${width} px`);
      if (process.env.PAGE_SHOT) await page.screenshot({ path: `${process.env.PAGE_SHOT}-${width}-${tab}.png` });
      if (width < DRAWERS_PX) await page.keyboard.press("Escape");
    }
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  await pausedSaysWhy({ page, until, robocell });
  await keyboardAlone({ page, look, until });
  forgive(/never/);
}

async function fits(page, width) {
  const wrong = await page.evaluate((drawers) => {
    const wrong = [];
    const shown = (node) => node.checkVisibility({ visibilityProperty: true });
    if (document.documentElement.scrollWidth > innerWidth) wrong.push("the page is wider than its window");
    const view = document.getElementById("view").clientWidth;
    if (view < (innerWidth < drawers ? innerWidth : 360)) wrong.push(`the view is ${view} px wide`);
    const pen = document.createElement("canvas").getContext("2d");
    for (const select of [...document.querySelectorAll("select")].filter(shown)) {
      pen.font = getComputedStyle(select).font;
      const text = select.selectedOptions[0]?.text ?? "";
      // The arrow and the padding take their place.
      if (pen.measureText(text).width + 24 > select.clientWidth)
        wrong.push(`"${text}" is cut at ${select.clientWidth} px`);
    }
    for (const node of [...document.querySelectorAll("#top > *, #bottom > *")].filter(shown)) {
      const { left, right } = node.getBoundingClientRect();
      if (left < -1 || right > innerWidth + 1) wrong.push(`${node.className} is outside of the window`);
    }
    return wrong;
  }, DRAWERS_PX);
  if (wrong.length > 0) throw new Error(`at ${width} px: ${wrong.join("; ")}`);
}

/** The page shows the reason of a pause. */
async function pausedSaysWhy({ page, until, robocell }) {
  const says = (text) => page.locator(".time .cause", { hasText: text }).waitFor();
  robocell("pause");
  await says("by an operator");
  robocell("step", "3");
  await says("the step is done");
  robocell("resume");
  await until("it continues", noFlag(PAUSED));
}

/** The keys lead to everything that is needed. */
async function keyboardAlone({ page, look, until }) {
  await page.locator("body").click({ position: { x: 640, y: 300 } });
  await page.keyboard.press("Space");
  await until("Space paused", flag(PAUSED));
  const tick = await look((r) => r.store.snapshot.tick);
  await page.keyboard.press(".");
  await until("the point stepped", (r, tick) => r.store.snapshot.tick > tick, tick);
  await page.keyboard.press("Space");
  await until("Space resumed", noFlag(PAUSED));
  await page.keyboard.press("?");
  await page.locator("dialog.help").waitFor();
  await page.keyboard.press("Escape");
  // One tab stop for the whole list of events, and the arrows within it.
  const stops = await page.evaluate(
    () => document.querySelectorAll('.event-list [tabindex="0"], .event-list button:not([tabindex])').length,
  );
  if (stops > 0) throw new Error(`${stops} tab stops in the list of events`);
  await page.getByRole("tab", { name: "Task" }).click();
  await page.locator(".event-list").focus();
  await page.keyboard.press("ArrowUp");
  const inList = await page.evaluate(() => document.activeElement?.closest(".event") !== null);
  if (!inList) throw new Error("the arrow does not lead to a line of the list");
}
