// Leading an arm joint by joint, on the page and by the command beside it.
import { flag, noFlag, PAUSED, TASK_PAUSED } from "./flags.mjs";

const DEG = Math.PI / 180;

/** A slider moves its joint and no other one, within what the drives allow. */
export async function joints({ page, look, until, press, robocell }) {
  await press("robocell resume");
  await until("the cell runs", noFlag(PAUSED));
  await page.getByRole("tab", { name: "Robot" }).click();
  const form = page.locator(".joint-form");
  const [name] = await look((r) => r.store.scene.arms[0].joints.map(({ name }) => name));
  const slider = form.getByLabel(`${name} (degrees)`);
  // While the task leads the arm nothing can be moved, and the form says why.
  await form.getByText("pause the task first").waitFor();
  if (!(await slider.isDisabled())) throw new Error("the sliders of a running task are on");
  robocell("task", "pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await until("the arm is at rest", (r) => r.store.snapshot.arms[0].velocities.every((rate) => Math.abs(rate) < 1e-3));
  const before = await look((r) => [...r.store.snapshot.arms[0].positions]);
  await slider.focus();
  for (let press = 0; press < 10; press++) await page.keyboard.press("ArrowRight");
  const isThere = (r, [joint, to]) => Math.abs(r.store.snapshot.arms[0].positions[joint] - to) < 0.01;
  await until("the joint moved by ten degrees", isThere, [0, before[0] + 10 * DEG]);
  const after = await look((r) => [...r.store.snapshot.arms[0].positions]);
  const moved = after.slice(1, 7).filter((position, index) => Math.abs(position - before[index + 1]) > 0.02);
  if (moved.length > 0) throw new Error(`other joints moved: ${before} became ${after}`);
  const shown = Number.parseFloat(await form.locator(".joint-slider").nth(1).locator(".num").nth(1).innerText());
  if (Math.abs(shown - after[0] / DEG) > 1)
    throw new Error(`measured is shown as ${shown} of ${after[0] / DEG} degrees`);
  // The command does alike, and the slider follows.
  robocell("joints", ...before.slice(0, 7).map((position) => position.toFixed(4)));
  await until("the command moved it back", isThere, [0, before[0]]);
  await until(
    "the slider follows",
    (_, [name, to]) => Math.abs(Number(document.querySelector(`[aria-label="${name} (degrees)"]`).value) - to) < 1,
    [name, before[0] / DEG],
  );
}

/** The labels of an axis differ, however small the values are. */
export async function ticks({ page, look, until, press, same }) {
  await press("robocell resume");
  await page.getByRole("tab", { name: "Plots" }).click();
  const labels = (_r) => [...document.querySelectorAll(".plot")].map((node) => node.plot.labels());
  // A cube at rest moves by less than a micrometre.
  for (const chip of await page.locator(".plot .chip").all())
    if (chip !== undefined) await page.locator(".plot .chip").first().click();
  const name = await look((r) => r.store.scene.objects[0].name);
  await page.getByLabel("Find a signal").fill(`${name} z`);
  await page.locator(".signal", { hasText: `${name} z` }).click();
  await until(
    "the axis has labels",
    `(r) => (${labels})(r).some((one) => one.filter((text) => text !== "").length > 2)`,
  );
  for (const one of await look(labels)) {
    const told = one.filter((text) => text !== "");
    same("labels of one axis", told, [...new Set(told)]);
  }
}
