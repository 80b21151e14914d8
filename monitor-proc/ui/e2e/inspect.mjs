// What a person asks of single objects, joints and panels.
import { flag, TASK_PAUSED } from "./flags.mjs";

/** The numbers of a row of the card. */
async function numbers(page, row) {
  const text = await page.locator(`.inspect [data-row="${row}"] b`).innerText();
  return text.split(/[,;]/).map(Number);
}

/** A click on an object shows its position, its holder and its contacts. */
export async function inspector({ page, look, until, press, robocell, same, near }) {
  const objects = await look((r) => r.store.scene.objects.map(({ name }) => name));
  const name = objects[0];
  const [x, y] = await look((r, name) => r.view.screenOf(name), name);
  await page.mouse.click(x, y);
  const card = page.locator(".inspect");
  await card.getByRole("heading", { name }).waitFor();
  const pose = await look((r) => r.store.snapshot.objects[0].pose);
  near("the card's position", await numbers(page, "position"), pose.slice(0, 3), 2e-3);
  const mass = await look((r) => r.store.scene.objects[0].mass_kg);
  near("the card's mass", await numbers(page, "mass"), [mass], 1e-3);
  // It rests on the table, which bears its weight.
  const bears = async () => {
    const line = card.locator(".touches li", { hasText: "N" }).first();
    const force = Number((await line.locator("b").innerText()).replace(" N", ""));
    return [await line.locator("span").innerText(), force];
  };
  await press("robocell resume");
  await until("the weight is borne", (r) =>
    r.store.snapshot.contacts.some(({ a, b }) => [a, b].some(({ kind, index }) => kind === "object" && index === 0)),
  );
  await card.locator(".touches li b", { hasText: "N" }).first().waitFor();
  const [partner, force] = await bears();
  same("the partner", partner, "table");
  if (Math.abs(force - 9.81 * mass) > 0.3 * 9.81 * mass)
    throw new Error(`the table bears ${force} N of ${9.81 * mass} N`);
  // The card follows what an arm carries.
  await until("an object is held", (r) => r.store.snapshot.arms.some(({ held }) => held !== null));
  const [held, arm] = await look((r) => {
    const { arms } = r.store.snapshot;
    const arm = arms.findIndex(({ held }) => held !== null);
    return [r.store.scene.objects[arms[arm].held].name, r.store.scene.arms[arm].name];
  });
  // A second click on a row closes the card.
  if (held !== name) await page.locator(`.tree-row[data-name="${held}"]`).click();
  await card.getByRole("heading", { name: held }).waitFor();
  await card.locator('[data-row="held by"] b', { hasText: arm }).waitFor();
  await card.locator(".touches li", { hasText: arm }).first().waitFor();
  // Fixtures and arms have a card, too.
  await page.locator('.tree-row[data-name="table"]').click();
  await card.getByRole("heading", { name: "table" }).waitFor();
  await page.locator(`.tree-row[data-name="${arm}"]`).click();
  await card.locator('[data-row="TCP position"]').waitFor();
  await card.getByRole("button", { name: "Robot tab" }).click();
  same("the open tab", await page.getByRole("tab", { selected: true }).innerText(), "Robot");
  await page.keyboard.press("Escape");
  await card.waitFor({ state: "hidden" });
  await dragged({ page, look, until, press, robocell });
}

/** An object goes where the card's numbers send it. */
async function dragged({ page, look, until, press, robocell }) {
  robocell("task", "pause");
  await until("the task is paused", flag(TASK_PAUSED));
  const free = await look((r) => {
    const held = r.store.snapshot.arms.map(({ held }) => held);
    return r.store.scene.objects.findIndex((_, index) => !held.includes(index));
  });
  const [name, pose] = await look((r, i) => [r.store.scene.objects[i].name, r.store.snapshot.objects[i].pose], free);
  await page.locator(`.tree-row[data-name="${name}"]`).click();
  await press(`robocell grasp ${name}`);
  await page.locator(".grasps li", { hasText: "chosen" }).waitFor();
  const to = [pose[0] + 0.05, pose[1], pose[2] + 0.02];
  for (const [axis, label] of ["x (m)", "y (m)", "z (m)"].entries()) {
    await page.locator(".inspect").getByLabel(label).fill(to[axis].toFixed(3));
  }
  await press(`robocell drag ${name} --to`);
  await until("it was pulled there", (r, [i, x]) => Math.abs(r.store.snapshot.objects[i].pose[0] - x) < 0.02, [
    free,
    to[0],
  ]);
}
