// Leading an arm by hand: keys, buttons, handles, and what comes of it.
import { flag, TASK_PAUSED } from "./flags.mjs";

const where = (r) => r.store.snapshot.arms[0].target;

/** Waits until the arm is at rest. */
async function rest({ look, until, page }) {
  await page.waitForTimeout(600);
  const time = await look((r) => r.store.snapshot.time);
  await until(
    "the arm is at rest",
    (r, then) => r.store.snapshot.time > then && r.store.snapshot.arms[0].velocities.every((v) => Math.abs(v) < 2e-3),
    time + 0.5,
  );
}

/** Waits until the target is `offset` (m) away from `from`. */
async function moved({ until }, what, from, offset) {
  const off = (r, [from, offset]) => {
    const { target, targetValid } = r.store.snapshot.arms[0];
    return targetValid && offset.every((by, axis) => Math.abs(target[axis] - from[axis] - by) < 2e-5);
  };
  await until(what, off, [from, offset]);
}

/** Keys in the view and buttons move and turn the target; Go waits where it is asked to. */
export async function jog(test) {
  const { page, look, until, press, same } = test;
  await press("robocell resume");
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await page.getByRole("tab", { name: "Robot" }).click();
  await page.getByRole("button", { name: "Point down" }).click();
  await until("a target leads the arm", (r) => r.store.snapshot.arms[0].targetValid);
  await rest(test);
  const view = page.getByRole("application");
  await view.focus();
  let from = await look(where);
  // The picture's right is y or x of the world; up is z.
  await page.keyboard.press("PageUp");
  await moved(test, "a key moves the target up by 1 mm", from, [0, 0, 0.001]);
  await page.keyboard.press("Shift+PageUp");
  await moved(test, "with Shift by a tenth", from, [0, 0, 0.0011]);
  await page.getByRole("button", { name: "10 mm, 10°" }).click();
  await page.getByRole("button", { name: "y minus" }).click();
  await moved(test, "a button moves it along y", from, [0, -0.01, 0.0011]);
  // Turned about the vertical, it stays where it is.
  await view.focus();
  await page.keyboard.press("e");
  await page.getByRole("button", { name: "1 mm, 1°" }).click();
  from = await look(where);
  await view.focus();
  await page.keyboard.press("PageUp");
  const turned = (r, [from, degrees]) => {
    const { target } = r.store.snapshot.arms[0];
    const cosine = Math.abs([3, 4, 5, 6].reduce((sum, i) => sum + target[i] * from[i], 0));
    const angle = (2 * Math.acos(Math.min(cosine, 1)) * 180) / Math.PI;
    return Math.abs(angle - degrees) < 0.1 && Math.abs(target[2] - from[2]) < 2e-5;
  };
  await until("a key turns the target by a degree", turned, [from, 1]);
  await page.keyboard.press("t");
  await page.getByRole("button", { name: "with Go" }).click();
  from = await look(where);
  for (let press = 0; press < 5; press++) await page.getByRole("button", { name: "x plus" }).click();
  await page.locator("#view .label", { hasText: "Go (Enter)" }).waitFor();
  same("the target before Go", await look(where), from);
  await view.focus();
  await page.keyboard.press("Enter");
  await moved(test, "Enter moves it", from, [0.005, 0, 0]);
  await page.getByRole("button", { name: "follow", exact: true }).click();
  await page.getByRole("button", { name: "hold", exact: true }).click();
  from = await look(where);
  const key = page.getByRole("button", { name: "z plus" });
  await key.hover();
  await page.mouse.down();
  await until(
    "a button that is held moves the target on",
    (r, from) => r.store.snapshot.arms[0].target[2] > from[2] + 0.01,
    from,
  );
  await page.mouse.up();
  await page.waitForTimeout(700);
  const stopped = await look(where);
  await page.waitForTimeout(500);
  same("the target after the button is released", await look(where), stopped);
}

/** A held object is brought above another one, and down onto it. */
async function placed(test) {
  const { page, look, near } = test;
  const cubes = () =>
    look((r) =>
      ["red_cube", "blue_cube"].map((name) =>
        r.store.snapshot.objects[r.store.scene.objects.findIndex((one) => one.name === name)].pose.slice(0, 3),
      ),
    );
  const raised = ([x, y, z], by) => [x, y, z + by];
  const SIDE_M = 0.05;
  await page.locator('.tree-row[data-name="blue_cube"]').click();
  await page.getByRole("button", { name: "Above", exact: true }).click();
  await rest(test);
  const [above, below] = await cubes();
  near("the cube that is held", above, raised(below, 0.1 + SIDE_M), 0.004);
  await page.getByRole("button", { name: "Place", exact: true }).click();
  await rest(test);
  const [on, under] = await cubes();
  near("the cube that is set down", on, raised(under, SIDE_M), 0.004);
}

/** Above, Approach and the gripper take an object; every outcome is said. */
export async function grasp(test) {
  const { page, look, until, press, near } = test;
  const said = async (text) => {
    const toast = page.locator(".toast", { hasText: text }).last();
    await toast.waitFor();
    await toast.getByRole("button", { name: "Close" }).click();
  };
  // In this order: the task must not bring the tool above the cube meanwhile.
  await press("robocell task pause");
  await press("robocell resume");
  await until("the task is paused", flag(TASK_PAUSED));
  await page.getByRole("tab", { name: "Robot" }).click();
  await page.getByRole("button", { name: "Close gripper" }).click();
  await said("gripped nothing: nothing is there; the nearest object is");
  await page.getByRole("button", { name: "Open gripper" }).click();
  await page.locator('.tree-row[data-name="red_cube"]').click();
  await page.getByRole("button", { name: "Approach", exact: true }).click();
  await said("press Above first");
  await page.getByRole("button", { name: "Above", exact: true }).click();
  await rest(test);
  const [tcp, cube] = await look((r) => [
    r.store.snapshot.arms[0].tcp,
    r.store.snapshot.objects[r.store.scene.objects.findIndex(({ name }) => name === "red_cube")].pose,
  ]);
  near("the tool", tcp.slice(0, 2), cube.slice(0, 2), 0.004);
  await page.getByRole("button", { name: "Approach", exact: true }).click();
  await until("the tool is at the grasp", (r, z) => Math.abs(r.store.snapshot.arms[0].tcp[2] - z) < 0.015, cube[2]);
  await rest(test);
  await page.getByRole("button", { name: "Close gripper" }).click();
  await said("gripped red_cube");
  await page.locator("#view .label.outcome", { hasText: "gripped red_cube" }).waitFor();
  const fields = page.locator(".target-form");
  await fields.getByLabel("z", { exact: true }).fill("0.2");
  await fields.getByRole("button", { name: "Go", exact: true }).click();
  await until(
    "the cube is lifted",
    (r) => r.store.snapshot.arms[0].held !== null && r.store.snapshot.arms[0].tcp[2] > 0.18,
  );
  await rest(test);
  await placed(test);
  await fields.getByLabel("z", { exact: true }).fill("0.2");
  await fields.getByRole("button", { name: "Go", exact: true }).click();
  await until(
    "the cube is lifted again",
    (r) => r.store.snapshot.arms[0].held !== null && r.store.snapshot.arms[0].tcp[2] > 0.18,
  );
  await rest(test);
  // Into the table, or the other cube: it is pressed on it with no more than the limit.
  await fields.getByLabel("z", { exact: true }).fill("-0.1");
  await fields.getByRole("button", { name: "Go", exact: true }).click();
  await said("stopped at a contact");
  await page.getByRole("button", { name: "Open gripper" }).click();
  await page.getByRole("tab", { name: "Task" }).click();
  await page.locator('.event[data-mark="hand"]', { hasText: "gripped red_cube" }).waitFor();
}
