// What a person finds out about objects, and joints led by hand.
import { PAUSED, TASK_PAUSED, flag } from "./flags.mjs";

/** The card of an object tells where it is, what it weighs on, and who holds it. */
export async function inspector({ page, look, until, robocell, near }) {
  robocell("step", "500");
  await until("it rests", (r) => r.store.snapshot.tick >= 500 && r.store.snapshot.contacts.length > 0);
  await page.setViewportSize({ width: 1600, height: 900 });
  await page.locator('#left [data-name="red_cube"]').click();
  const card = page.getByRole("region", { name: "Selected object" });
  await card.getByText("red_cube", { exact: true }).waitFor();
  await card.locator("dd", { hasText: /\d/ }).first().waitFor();
  const value = async (name) => (await card.locator(`dt:has-text("${name}") + dd`).first().textContent()) ?? "";
  const shown = (await value("position (m)")).split(" ").map(Number);
  near("the position shown", shown, await look((r) => r.store.snapshot.objects[0].pose.slice(0, 3)), 2e-3);
  const mass = Number(await value("mass (kg)"));
  const force = Number.parseFloat(await value("table"));
  if (!(Math.abs(force - 9.81 * mass) < 0.1)) throw new Error(`the table bears ${force} N of ${mass} kg`);
  robocell("resume");
  await until("it is held", (r) => r.store.snapshot.arms[0].held === 0);
  for (const since = Date.now(); (await value("held by")) !== "panda"; ) {
    if (Date.now() - since > 20_000) throw new Error(`held by ${await value("held by")}`);
    await page.waitForTimeout(50);
  }
  await page.keyboard.press("Escape");
  await card.waitFor({ state: "hidden" });
}

/** A slider leads a joint while the task is paused. */
export async function jog({ page, look, until, press }) {
  await page.setViewportSize({ width: 1600, height: 900 });
  await press("robocell resume");
  await page.getByRole("tab", { name: "Robot" }).click();
  const slider = page.getByLabel("Lead joint joint1", { exact: false }).first();
  if (await slider.isVisible()) throw new Error("a slider is offered while the task leads");
  await page.getByRole("tab", { name: "Task" }).click();
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await page.getByRole("tab", { name: "Robot" }).click();
  await slider.waitFor();
  const before = await look((r) => r.store.snapshot.arms[0].positions[0]);
  const to = before > 0 ? before - 0.5 : before + 0.5;
  await slider.fill(to.toFixed(3));
  await until("the joint is there", (r, to) => Math.abs(r.store.snapshot.arms[0].positions[0] - to) < 0.01, to);
  if (await look((r) => (r.store.snapshot.flags & 1) !== 0)) throw new Error(`paused: ${PAUSED}`);
}

/** What was added and dropped is said. */
export async function feedback({ page, look, press, robocell, until }) {
  const demo = await look((r) => r.store.scene.demo);
  robocell("resume");
  await until("it runs", (r) => r.store.snapshot.time > 0.2);
  await page.locator("#right [role=tab]").last().click();
  if (demo === "ur10-fill-bin") {
    await press("robocell drop-parts");
    await page.getByText(/Dropped parts: \d+ of \d+ so far/).waitFor();
  } else {
    await press("robocell add-bin --flipped");
    await page.getByText(/Added bin_\d+, upside down/).waitFor();
  }
}
