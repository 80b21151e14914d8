// Bins stacked by hand on the page, and the buttons of their panels.
import { flag, noFlag, PAUSED, TASK_PAUSED } from "./flags.mjs";

const DOWN_DEG = { roll: 0, pitch: 90 };
/** Height of the cup over the bin it is to grip (m). */
const GAP_M = 0.002;
const DEG = 180 / Math.PI;

/** Leads the tool of the UR10 to a pose by the numbers of the robot tab. */
async function lead({ page, until }, at, yaw_rad = 0, { within = 0.004, roll, pitch } = { ...DOWN_DEG }) {
  await page.getByRole("tab", { name: "Robot" }).click();
  const metres = ["x", "y", "z"].map((name, axis) => [name, at[axis].toFixed(4)]);
  // The cup, along x of its frame, looks down at first.
  const turn = { roll: roll ?? DOWN_DEG.roll, pitch: pitch ?? DOWN_DEG.pitch, yaw: yaw_rad * DEG };
  const degrees = Object.entries(turn).map(([name, angle]) => [name, angle.toFixed(2)]);
  for (const [name, text] of [...metres, ...degrees]) {
    await page.getByLabel(name, { exact: true }).fill(text);
  }
  await page.locator(".target-form button.primary").click();
  await until(
    `the tool is at ${at.map((x) => x.toFixed(3))}`,
    (r, [at, within]) => {
      const { tcp, target, velocities } = r.store.snapshot.arms[0];
      const off = (pose) => Math.hypot(...at.map((x, axis) => pose[axis] - x));
      const cosine = Math.abs([3, 4, 5, 6].reduce((sum, i) => sum + tcp[i] * target[i], 0));
      const turned = cosine > Math.cos(0.5 * Math.max(0.05, 4 * within));
      return off(target) < 1e-3 && off(tcp) < within && turned && velocities.every((v) => Math.abs(v) < 5e-3);
    },
    [at, within],
  );
}

/** Lets the cell run on for a while (s, its own time: a busy page shows it late). */
async function later({ look, until }, span) {
  const time = await look((r) => r.store.snapshot.time);
  await until("time goes by", (r, then) => r.store.snapshot.time > then, time + span);
}

/** Waits until the numbers that \`where\` gives stay as they are (m). */
async function still(test, where, within = 1e-4) {
  for (
    let [before, now] = [null, await where()];
    before === null || now.some((x, axis) => Math.abs(x - before[axis]) > within);
  ) {
    await later(test, 0.5);
    [before, now] = [now, await where()];
  }
}

/** How far a pixel moves the target along the gizmo's arrow at first (m). */
const PIXEL_M = 1.2e-3;

/** Pulls the target to the height `z` by the gizmo's arrow, as an eye and a hand do:
 * a little, looking where it is, until it is within 2 mm. */
async function pullTo({ page, look }, z) {
  const height = () => look((r) => r.store.snapshot.arms[0].target[2]);
  const [x, y] = await look((r) => r.view.screenOf("gizmo z"));
  await page.mouse.move(x, y);
  await page.waitForTimeout(300);
  await page.mouse.down();
  let [at, metres] = [y, await height()];
  const from = metres;
  for (let step = 0; Math.abs(z - metres) > 2e-3; step++) {
    if (step > 200) throw new Error(`the gizmo does not reach ${z} m: it is at ${metres} m`);
    const moved = Math.abs(at - y) > 5 ? (metres - from) / (y - at) : PIXEL_M;
    const pixels = (z - metres) / Math.max(moved, PIXEL_M / 4);
    at -= Math.sign(pixels) * Math.min(8, Math.max(1, Math.abs(pixels)));
    await page.mouse.move(x, at);
    await page.waitForTimeout(100);
    metres = await height();
  }
  await page.mouse.up();
}

/** A bin that is being taken by hand. */
class Bin {
  constructor(test, index, name, shape) {
    Object.assign(this, { test, index, name, wall: shape.wall_m, high: shape.size_m[2] });
  }

  pose() {
    return this.test.look((r, bin) => r.store.snapshot.objects[bin].pose, this.index);
  }

  /** Whether it opens upward. */
  async opensUp() {
    const [, , , , x, y] = await this.pose();
    return 1 - 2 * (x * x + y * y) > 0;
  }

  /** Direction of its long side, between -90 and 90 degrees (rad). */
  async along() {
    const [, , , w, x, y, z] = await this.pose();
    const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    return Math.atan2(Math.sin(2 * yaw), Math.cos(2 * yaw)) / 2;
  }

  /** From its middle up to the face the cup grips from above (m). */
  async face() {
    return (await this.opensUp()) ? this.wall - this.high / 2 : this.high / 2;
  }
}

/** Pauses the task when the first bin comes past `end_m` (y), and waits until the
 * bin rests: the belt stops where bins are taken from it, paused or not. The cell
 * waits for its start: no other bin has been moved. */
async function firstBin(test, end_m) {
  const { look, until, press } = test;
  const here = (r, end) => {
    const at = r.store.snapshot.objects.findIndex(({ flags, pose }) => (flags & 1) !== 0 && pose[1] < end);
    return at;
  };
  await press("robocell resume");
  await until("the cell runs", noFlag(PAUSED));
  if (await look((r) => r.store.scene.start_event)) await press("robocell task start");
  await until("a bin comes down the belt", `(r, end) => (${here})(r, end) >= 0`, end_m);
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await until("the arm stands", (r) => r.store.snapshot.arms[0].velocities.every((v) => Math.abs(v) < 1e-3));
  const index = await look(here, end_m);
  const { name, shape } = await look((r, bin) => r.store.scene.objects[bin], index);
  const bin = new Bin(test, index, name, shape);
  await still(test, () => bin.pose());
  return bin;
}

/** Presses the gripper's button on the demo's own panel; the label names its action. */
async function cup({ page, press, until }, to) {
  await page.getByRole("tab").last().click();
  await press(`robocell gripper ${to}`);
  await until(
    `the cup is switched ${to === "close" ? "on" : "off"}`,
    (r, on) => r.store.status.equipment.suction[0].on === on,
    to === "close",
  );
}

/** Goes down to the face at `top` by the gizmo and closes the cup; a little lower
 * where it found nothing, as a person would. */
async function grip(test, top) {
  const { look, page } = test;
  const tries = [];
  for (const gap_m of [0.004, 0.002, 0]) {
    await pullTo(test, top + gap_m);
    // What the tool is still off it would push with.
    await still(test, () => look((r) => r.store.snapshot.arms[0].tcp.slice(0, 3)));
    const answer = () =>
      look((r) => ({ held: r.store.snapshot.arms[0].held, refusals: r.store.status.equipment.suction[0].refusals }));
    const before = await answer();
    await cup(test, "close");
    for (const since = Date.now(); Date.now() - since < 20_000; ) {
      const { held, refusals } = await answer();
      if (held !== null) return;
      if (refusals > before.refusals) break;
      await page.waitForTimeout(100);
    }
    tries.push(await look((r) => ({ tcp: r.store.snapshot.arms[0].tcp, ...r.store.status.equipment.suction[0] })));
    await cup(test, "open");
  }
  throw new Error(`the cup does not grip the face at ${top}: ${JSON.stringify(tries)}`);
}

/** Takes `bin` off the belt: over it by numbers, down to it and up with it by the
 * gizmo. */
async function take(test, bin, yaw) {
  const [x, y, z] = await bin.pose();
  const top = z + (await bin.face());
  await lead(test, [x, y, top + 0.1], yaw);
  await grip(test, top);
  await pullTo(test, top + 0.12);
  await test.until("the gizmo lifts the bin", (r, [bin, z]) => r.store.snapshot.objects[bin].pose[2] > z + 0.1, [
    bin.index,
    z,
  ]);
  return [x, y, z];
}

/** Fails with the state of the suction if the cup has lost its bin. */
async function holds({ look }) {
  const { held, suction } = await look((r) => ({
    held: r.store.snapshot.arms[0].held,
    suction: r.store.status.equipment.suction[0],
  }));
  if (held === null) throw new Error(`the cup has lost its bin: ${JSON.stringify(suction)}`);
}

/** Sets `bin` down so that its middle is at `goal`, with the cup turned to `yaw`. */
async function setDown(test, bin, goal, yaw, over_m) {
  await lead(test, [goal[0], goal[1], over_m], yaw);
  await holds(test);
  // What hangs beside the cup's axis stays beside it.
  const [held, tcp] = await test.look(
    (r, bin) => [r.store.snapshot.objects[bin].pose, r.store.snapshot.arms[0].tcp],
    bin.index,
  );
  const at = goal.map((x, axis) => x + tcp[axis] - held[axis]);
  await lead(test, [at[0], at[1], at[2] + GAP_M], yaw, { within: 0.003 });
  await holds(test);
  await cup(test, "open");
  // Straight up out of it: on a long way the arm bows, and would drag the bin along.
  await pullTo(test, at[2] + 0.15);
  await test.until("the tool is out of the bin", (r, z) => r.store.snapshot.arms[0].tcp[2] > z + 0.14, at[2]);
  test.near("the bin", (await bin.pose()).slice(0, 3), goal, 0.02);
}

/** Gives the job back to the automation, which has to count the bin. */
async function counted({ page, press, until }, bin) {
  await page.getByRole("tab", { name: "Task" }).click();
  await press("robocell task resume");
  await until("the automation counts it", (r, name) => r.store.status.task.placed.includes(name), bin.name);
}

/** A person stacks an upside-down bin; the automation counts it. */
export async function manual(test) {
  const bin = await firstBin(test, 0.56);
  test.same("whether the first bin opens upward", await bin.opensUp(), false);
  const column = await test.look((r) => r.store.scene.task.stack.first_m);
  // Its long sides lie along x here and along y in its column: the tool turns back.
  const turn = Math.PI / 2 + (await bin.along());
  const [x, y, z] = await take(test, bin, turn);
  await lead(test, [x, y, z + 0.6], turn);
  await lead(test, [0.62, 0.14, 0.2], turn / 2, { within: 0.05 });
  await setDown(test, bin, [column[0], column[1], column[2] + bin.high / 2], 0, 0);
  await counted(test, bin);
}

/** A person takes a bin over that the automation has turned, sets it down on the
 * flipping station and leaves it there; the automation grips it again from its
 * bottom, stacks it and counts it. */
export async function flip(test) {
  const { look, until, press, same } = test;
  const first = await firstBin(test, 0.56);
  same("whether the first bin opens upward", await first.opensUp(), true);
  await press("robocell task resume");
  await until(
    "the bin is turned over and held before the station",
    (r, bin) => {
      const [, , , , x, y] = r.store.snapshot.objects[bin].pose;
      return r.store.status.task.phase === "FLIPPING" && 1 - 2 * (x * x + y * y) < -0.99;
    },
    first.index,
  );
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  const station = await look((r) => r.store.scene.task.station);
  const out = [Math.cos(station.yaw_rad), Math.sin(station.yaw_rad)];
  // The cup looks up; its z axis points along the rails.
  const up = { roll: -90, pitch: -90, within: 0.005 };
  const to = async (at) => lead(test, at, station.yaw_rad - Math.PI / 2, up);
  /** Where the tool is when the bin is `height` above its place on the rails. */
  const over = async (height, back) => {
    const [held, tcp] = [await first.pose(), await look((r) => r.store.snapshot.arms[0].tcp)];
    const [x, y, z] = station.position_m;
    const goal = [x - out[0] * back, y - out[1] * back, z + height + first.high / 2];
    return goal.map((one, axis) => one + tcp[axis] - held[axis]);
  };
  await to(await over(station.lift_m, station.slide_m));
  await to(await over(station.lift_m, 0));
  const [x, y, z] = await over(GAP_M, 0);
  await to([x, y, z]);
  await cup(test, "open");
  const below = z - station.push_down_m;
  await to([x, y, below]);
  await to([x - out[0] * station.slide_m, y - out[1] * station.slide_m, below]);
  same("whether the bin opens upward on the station", await first.opensUp(), false);
  test.near("the bin", (await first.pose()).slice(0, 2), station.position_m.slice(0, 2), 0.03);
  await counted(test, first);
}

/** A person palletizes an upright bin; the automation counts it. */
export async function pallet(test) {
  const bin = await firstBin(test, 0.85);
  test.same("whether the first bin opens upward", await bin.opensUp(), true);
  const { slot_x_m, slot_y_m, slot_z_m } = await test.look((r) => r.store.scene.task);
  const turn = Math.PI / 2 + (await bin.along());
  const [x, y, z] = await take(test, bin, turn);
  await lead(test, [x, y, z + 0.6], turn);
  await lead(test, [0.62, 0.4, 0.35], turn / 2, { within: 0.05 });
  await setDown(test, bin, [slot_x_m[1], slot_y_m[1], slot_z_m], 0, 0);
  await counted(test, bin);
}

/** The buttons of the bins' panels, each beside its command. */
export async function bins({ page, look, until, press, robocell, same }) {
  const panel = await look((r) => r.store.scene.panel);
  await press("robocell task pause");
  await until("the task is paused", flag(TASK_PAUSED));
  await page.getByRole("tab").last().click();
  const here = () => look((r) => r.store.snapshot.objects.filter(({ flags }) => (flags & 1) !== 0).length);
  const more = (what, count) =>
    until(what, (r, count) => r.store.snapshot.objects.filter(({ flags }) => (flags & 1) !== 0).length >= count, count);
  if (panel === "fill_bin") {
    const before = await here();
    const drop = await look((r) => r.store.scene.dispenser.per_drop);
    await press("robocell drop-parts");
    await more("the button drops parts", before + drop);
    await until("it is told", (r, drop) => r.store.status.equipment.parts_dropped === drop, drop);
    robocell("drop-parts", "5");
    await more("the command drops parts", before + drop + 5);
    await until("it is told", (r, drop) => r.store.status.equipment.parts_dropped === drop + 5, drop);
    await page.getByText(`${drop + 5} of 100 parts were dropped`).waitFor();
  } else {
    // A task that does not wait for its start has asked for bins already.
    robocell("reset");
    await until("no bin is here", (r) => r.store.snapshot.objects.every(({ flags }) => (flags & 1) === 0));
    await press("robocell add-bin");
    await more("the button brings a bin", 1);
    // Nothing has carried it away yet: the place is taken.
    robocell("reset");
    await until("it is gone", (r) => r.store.snapshot.objects.every(({ flags }) => (flags & 1) === 0));
    robocell("add-bin", "--flipped");
    await more("the command brings a bin", 1);
    const up = await look((r) => {
      const [, , , , x, y] = r.store.snapshot.objects.find(({ flags }) => (flags & 1) !== 0).pose;
      return 1 - 2 * (x * x + y * y) > 0;
    });
    same("whether it opens upward", up, false);
  }
  // Suction that finds nothing to hold stays on and says why.
  const cup = (what, on) => until(what, (r, on) => r.store.status.equipment.suction[0].on === on, on);
  // The task may have come as far as to switch it on.
  robocell("gripper", "open");
  await cup("it is off at first", false);
  await press("robocell gripper close");
  await until("the button switches suction on", (r) => r.store.status.equipment.suction[0].refusals > 0);
  const refused = await look((r) => r.store.status.equipment.suction[0].refusals);
  robocell("gripper", "open");
  await cup("the command switches it off", false);
  robocell("gripper", "close");
  await until("the command does alike", (r, n) => r.store.status.equipment.suction[0].refusals > n, refused);
}
