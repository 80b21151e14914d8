// A person does the robot's job: bins are gripped off the belt, one is turned over, and all are
// stacked by hand. Only texts and buttons of the page are used: no number from inside of it, no
// message of its socket.

/** The tool is at rest when its place has been the same in so many looks. */
const LOOKS = 4;
const LOOK_MS = 350;
/** What the fields of a target are called. */
const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"];

/** The numbers of a text. */
function numbersOf(text) {
  return (text.match(/-?\d+(\.\d+)?/g) ?? []).map(Number);
}

class Person {
  constructor({ page, press }) {
    Object.assign(this, { page, press });
  }

  async tab(name) {
    await this.page.getByRole("tab", { name, exact: true }).click();
  }

  /** Waits until `look` gives something; fails with `what`. */
  async until(what, look, patience_ms = 60_000) {
    for (const since = Date.now(); Date.now() - since < patience_ms; ) {
      const found = await look();
      if (found) return found;
      await this.page.waitForTimeout(100);
    }
    throw new Error(`waited in vain until ${what}`);
  }

  /** Selects a row of the scene, and reads a row of its card. */
  async card(name, row) {
    const card = this.page.getByRole("region", { name: "Selected" });
    const heading = card.getByRole("heading", { name, exact: true });
    if (!(await heading.isVisible()))
      await this.page
        .getByRole("button", { name: new RegExp(`^${name} `) })
        .first()
        .click();
    await heading.waitFor();
    return card.locator(".fact", { hasText: row }).locator("b").first().innerText();
  }

  /** Where an object or a fixture is (m). */
  async place(name) {
    return numbersOf(await this.card(name, "position"));
  }

  /** How far an object or a fixture is turned about the vertical (degrees). */
  async yaw(name) {
    return numbersOf(await this.card(name, "roll, pitch, yaw"))[2];
  }

  async cardButton(label) {
    await this.page.getByRole("region", { name: "Selected" }).getByRole("button", { name: label, exact: true }).click();
  }

  /** Waits until the numbers of the tool stay the same. */
  async rest() {
    await this.tab("Robot");
    const tool = this.page.locator(".fact", { hasText: "TCP" }).locator("b").first();
    let [same, before] = [0, ""];
    await this.until("the tool is at rest", async () => {
      await this.page.waitForTimeout(LOOK_MS);
      const now = await tool.innerText();
      // The last digit is a tenth of a millimetre.
      const isSame = numbersOf(now).every(
        (value, axis) => Math.abs(value - (numbersOf(before)[axis] ?? Infinity)) < 3e-4,
      );
      [same, before] = [isSame ? same + 1 : 0, now];
      return same >= LOOKS;
    });
    return numbersOf(before);
  }

  /** Fills fields of the target, and goes there. */
  async go(wanted) {
    await this.tab("Robot");
    for (const name of FIELDS) {
      const value = wanted[name];
      if (value !== undefined) await this.page.getByLabel(name, { exact: true }).fill(value.toFixed(4));
    }
    await this.page.locator(".target-form").getByRole("button", { name: "Go", exact: true }).click();
    return this.rest();
  }

  /** Leads the joints of the arm by their sliders (degrees). */
  async joints(wanted) {
    await this.tab("Robot");
    const sliders = this.page.locator(".joint-slider input");
    for (const [index, angle] of wanted.entries()) await sliders.nth(index).fill(String(angle));
    return this.rest();
  }

  /** What a field of the target shows. */
  async field(name) {
    await this.tab("Robot");
    return Number(await this.page.getByLabel(name, { exact: true }).inputValue());
  }

  /** What the line below the tool says (m). */
  async below() {
    const label = this.page.locator("#view .label", { hasText: /^\d+ mm to / }).first();
    return numbersOf(await label.innerText())[0] / 1000;
  }

  /** Waits for a notice, and closes it. */
  async notice(text) {
    const notice = this.page.locator(".toast", { hasText: text }).last();
    await notice.waitFor();
    const said = await notice.innerText();
    await notice.getByRole("button", { name: "Close" }).click();
    return said;
  }

  /** Simulated seconds by seconds. */
  async speed(factor) {
    await this.page.getByLabel("Speed", { exact: true }).selectOption(factor);
  }

  /** Presses the button of the gripper. */
  async gripper(label) {
    await this.tab("Robot");
    await this.page.getByRole("button", { name: label, exact: true }).click();
  }

  /** Closes the gripper; whether it holds `name`. */
  async close(name) {
    await this.gripper("Close gripper");
    return (await this.notice(/gripped/)).includes(`gripped ${name}`);
  }

  /** Goes over `name` and down to it, and grips it; a millimetre lower where nothing was there. */
  async grip(name) {
    await this.card(name, "position");
    await this.cardButton("Above");
    await this.rest();
    await this.cardButton("Approach");
    await this.rest();
    for (let tries = 0; tries < 4; tries++) {
      if (await this.close(name)) return;
      await this.gripper("Open gripper");
      await this.page.getByRole("button", { name: "z minus" }).click();
      await this.rest();
    }
    throw new Error(`the cup does not grip ${name}`);
  }

  /** The bins of the panel that are said to be `where`. */
  async bins(where) {
    await this.page.getByRole("tab").last().click();
    const rows = await this.page.locator(".cube-row").allInnerTexts();
    return rows.filter((text) => text.includes(where)).map((text) => text.split(/\s/)[0]);
  }
}

/** How fast the automation works: slow enough to be paused in time on a loaded machine. */
const WATCHED = "0.5";

/** Lets the automation work until `isTime`, and pauses it. */
async function automate(person, what, isTime) {
  await person.speed(WATCHED);
  await person.tab("Task");
  const resume = person.page.locator('button:visible[title*="$ robocell task resume"]').first();
  if (await resume.isVisible()) await resume.click();
  await person.until(what, isTime, 600_000);
  await person.tab("Task");
  await person.press("robocell task pause");
  await person.speed("1");
  await person.rest();
}

/** Waits until a bin is at rest at the end of the belt; whether it opens upward. */
async function arrives(person, name) {
  let before = "";
  await person.until(`${name} is at rest`, async () => {
    await person.page.waitForTimeout(700);
    const now = await person.card(name, "position");
    const isSame = now === before;
    before = now;
    return isSame;
  });
  return (await person.bins("opens up")).includes(name);
}

/** The next bin that has come to the end of the belt, and is not stacked; the automation brings one if none is there. */
async function nextBin(person, stacked) {
  const waiting = async () => {
    const others = (await person.bins("in the cell")).filter((name) => !stacked.includes(name));
    for (const name of others) if ((await person.place(name))[1] < 0.6) return name;
    return null;
  };
  let name = await waiting();
  if (name === null) {
    await automate(person, "a bin has come to the end of the belt", async () => (name = await waiting()) !== null);
  }
  return { name, opensUp: await arrives(person, name) };
}

/** A bin that is let go falls so far (m): on an edge that touches first it would be torn off the cup. */
const GAP_M = 0.004;
/** Where the arm holds a bin before the flipping station (degrees), as a person sees it done by the automation. */
const BEFORE_STATION = [-116, -101, -119, -50, 90];
/** The same with the cup upwards, and out of the way of a bin that stays behind. */
const HALF_TURNED = [-118, -104, -121, -48, 0];
const CUP_UP = [-123, -114.5, -122.7, -32.8, -89];
const OVER_STATION = [-122, -90, -102, -76, 89];
/** The rails are open towards the arm: a bin is slid in and the tool out for so much (m). */
const SLIDE_M = 0.22;
/** The tool goes down out of a bin by so much (m): more than the bin is high. */
const DOWN_M = 0.17;
/** The tool leaves a bin so far upwards (m). */
const LEAVE_M = 0.3;

/** Turns what the cup holds about the vertical until its long side points along `wanted` (degrees). */
async function turnTo(person, name, wanted) {
  const { page } = person;
  await person.tab("Robot");
  for (const [step, size] of [
    ["10 mm, 10°", 10],
    ["1 mm, 1°", 1],
  ]) {
    await page.getByRole("button", { name: step, exact: true }).click();
    for (let round = 0; round < 3; round++) {
      const yaw = await person.yaw(name);
      // A bin looks the same after half a turn.
      const off = ((((wanted - yaw + 90) % 180) + 180) % 180) - 90;
      const presses = Math.round(Math.abs(off) / size);
      if (presses === 0) break;
      const key = page.getByRole("button", { name: off > 0 ? "yaw plus" : "yaw minus", exact: true });
      for (let press = 0; press < presses; press++) {
        await key.click();
        await page.waitForTimeout(60);
      }
      await person.rest();
    }
  }
}

/** Moves the tool until the middle of the held object is at [x, y]. */
async function centre(person, name, [x, y]) {
  for (let look = 0; look < 2; look++) {
    const [bx, by] = await person.place(name);
    await person.go({ x: (await person.field("x")) + x - bx, y: (await person.field("y")) + y - by });
  }
}

/** Lowers what the cup holds by `height` (m) but for a small gap, lets go, and leaves upwards. */
async function lower(person, height, up_m) {
  const from = await person.field("z");
  await person.go({ z: from - height + 0.03 });
  await person.go({ z: from - height + GAP_M });
  await person.gripper("Open gripper");
  await person.rest();
  if (up_m !== 0) await person.go({ z: (await person.field("z")) + up_m });
}

/** Turns a bin over by hand: it is put on the rails from below, and gripped again from above. */
async function turnOver(person, name) {
  const before = await person.yaw(name);
  await person.go({ z: 0.12 });
  const turned = Math.abs(before - (await person.yaw(name))) % 180;
  if (Math.min(turned, 180 - turned) > 2)
    throw new Error(`a target that lifts ${name} also turned it by ${turned} degrees`);
  // Its long side away from the arm's own links: along the belt here.
  await turnTo(person, name, 90);
  await person.joints(BEFORE_STATION);
  await person.joints(HALF_TURNED);
  await person.joints(CUP_UP);
  const rails = [await person.place("holder_rail_left"), await person.place("holder_rail_right")];
  const yaw = await person.yaw("holder_rail_left");
  const out = [Math.cos((yaw * Math.PI) / 180), Math.sin((yaw * Math.PI) / 180)];
  const middle = [0, 1].map((axis) => (rails[0][axis] + rails[1][axis]) / 2 - 0.05 * out[axis]);
  await turnTo(person, name, yaw + 90);
  await person.go({ z: 0.45 });
  await centre(
    person,
    name,
    middle.map((at, axis) => at - SLIDE_M * out[axis]),
  );
  await centre(person, name, middle);
  // The line below the bin would go between the rails, so its height is taken from the cards.
  const half = numbersOf(await person.card(name, "shape"))[2] / 2000;
  const top = rails[0][2] + numbersOf(await person.card("holder_rail_left", "shape"))[2] / 2000;
  await lower(person, (await person.place(name))[2] - half - top, 0);
  // Down out of the bin, and back between the rails.
  await person.go({ z: (await person.field("z")) - DOWN_M });
  await person.go({ x: (await person.field("x")) - SLIDE_M * out[0], y: (await person.field("y")) - SLIDE_M * out[1] });
  await person.joints(BEFORE_STATION);
  await person.joints(OVER_STATION);
  await person.grip(name);
}

/** Carries what the cup holds over a place, and sets it down there. */
async function setDown(person, name, [x, y]) {
  await person.go({ z: 0.55 });
  await person.go({ x: 0.62, y: 0.14, z: 0.4 });
  await person.go({ x, y, z: 0.4 });
  await turnTo(person, name, 90);
  await centre(person, name, [x, y]);
  await lower(person, await person.below(), LEAVE_M);
}

/** How many bins the panel counts. */
async function placed(person) {
  await person.page.getByRole("tab").last().click();
  return numbersOf(await person.page.getByText(/of \d+ bins are placed/).innerText())[0];
}

/** Three bins are stacked by hand on that of the automation, which counts them; one of them is turned over. */
export async function hands(test) {
  const person = new Person(test);
  await test.page.setViewportSize({ width: 1600, height: 900 });
  await firstBin(person);
  const [first] = await person.bins("placed");
  const column = await person.place(first);
  const byHand = [];
  let turned = 0;
  while (byHand.length < 3) {
    const { name, opensUp } = await nextBin(person, [...byHand, first]);
    await person.grip(name);
    if (opensUp) {
      await turnOver(person, name);
      turned += 1;
    }
    await setDown(person, name, column);
    byHand.push(name);
  }
  test.same("bins that were turned over by hand", turned, 1);
  const isCounted = async () => {
    const all = await person.bins("placed");
    return byHand.every((name) => all.includes(name));
  };
  await automate(person, "the automation counts what was stacked by hand", isCounted);
}

/** The automation starts its job and stacks a bin. */
async function firstBin(person) {
  await person.tab("Task");
  const start = person.page.locator('button:visible[title*="$ robocell task start"]').first();
  if (await start.isVisible()) await start.click();
  await automate(person, "the automation has placed a bin", async () => (await placed(person)) > 0);
}
