// A job is watched, paused, looked back at and restarted without a mouse.
import { flag, NOT_LIVE, noFlag, PAUSED, starts } from "./flags.mjs";

const MOST_STOPS = 150;

/** Presses Tab until what has the focus is named `name`; says how many stops that took. */
async function tabTo(page, name, key = "Tab") {
  for (let stops = 0; stops < MOST_STOPS; stops++) {
    const named = await page.evaluate(() => {
      const node = document.activeElement;
      const text = node?.getAttribute("aria-label") ?? node?.labels?.[0]?.innerText ?? node?.innerText ?? "";
      // What has the focus is to be seen.
      const { width, height } = node?.getBoundingClientRect() ?? { width: 0, height: 0 };
      return width > 0 && height > 0 ? text.trim() : "";
    });
    if (name.test(named)) return;
    await page.keyboard.press(key);
  }
  throw new Error(`${MOST_STOPS} times ${key} does not lead to ${name}`);
}

export async function keyboard({ page, look, until, press, forgive }) {
  await page.setViewportSize({ width: 1600, height: 900 });
  await starts({ press, until });
  await until("some seconds are recorded", (r) => r.store.timeline?.to_s > 3);
  await tabTo(page, /^Pause simulated time$/);
  await page.keyboard.press("Enter");
  await until("Enter paused", flag(PAUSED));
  await tabTo(page, /^speed$/i);
  await page.keyboard.press("ArrowUp");
  await until("the arrow changed the speed", (r) => r.store.status.speed !== "1");
  await page.keyboard.press("ArrowDown");
  await until("and back", (r) => r.store.status.speed === "1");
  // The tabs are one stop; the arrows lead from one to the next.
  await tabTo(page, /^Task$/);
  await page.keyboard.press("ArrowRight");
  await page.locator('[role="tab"][aria-selected="true"]', { hasText: "Robot" }).waitFor();
  await page.keyboard.press("ArrowLeft");
  // Back in time, and to now.
  await tabTo(page, /^Time shown$/);
  const now = await look((r) => r.store.snapshot.time);
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowLeft");
  await until("the past is shown", flag(NOT_LIVE));
  await until("two tenths back", (r, now) => Math.abs(r.store.snapshot.time - now + 0.2) < 0.15, now);
  // The button is named with the next frame, after the state that it follows.
  await page.getByRole("button", { name: "Back to live" }).waitFor();
  await tabTo(page, /^Back to live$/, "Shift+Tab");
  await page.keyboard.press("Enter");
  await until("now is shown", noFlag(NOT_LIVE));
  // A process is restarted, and the cell resumes.
  const start = await look((r) => r.store.status.processes.find(({ name }) => name === "task").generation);
  await tabTo(page, /^Restart task$/i);
  await page.keyboard.press("Enter");
  await until(
    "the task was restarted",
    (r, start) => r.store.status.processes.find(({ name }) => name === "task").generation > start,
    start,
  );
  await tabTo(page, /^Play: /);
  await page.keyboard.press("Enter");
  await until("it resumed", noFlag(PAUSED));
  forgive(/never/);
}
