// Browser tests of the page of a running cell: `node page.mjs SCENARIO LINK`.
// ROBOCELL names the program for the commands' twins. Exits 1 with what was
// wrong; where PAGE_SHOT names a file, with a picture of the page at that moment.
// Started by tests/tests/page.rs.
import { spawnSync } from "node:child_process";
import { chromium } from "playwright-core";
import { scenarios } from "./scenarios.mjs";

const PATIENCE_MS = Number(process.env.PAGE_PATIENCE_MS ?? 120_000);

// WebGL by a program, as on a computer without a graphics card. Not the flags that also draw the page's panels with
// it: they cost more than the picture.
const FLAGS = [
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-sandbox",
];

/** Scenarios that begin as a first visit. */
const SEES_GUIDE = ["guide", "scenes"];
const DEMOS = [
  "franka-stack",
  "franka-pyramid",
  "reach",
  "reach-shelf",
  "ur10-palletize",
  "ur10-fill-bin",
  "ur10-bin-stack",
  "cube",
];

/** Runs the twin of a button. */
function robocell(...args) {
  const said = spawnSync(process.env.ROBOCELL, args, { encoding: "utf8" });
  if (said.status !== 0) throw new Error(`robocell ${args.join(" ")}: ${said.stderr}`);
  return said.stdout;
}

const [name, link] = process.argv.slice(2);
const scenario = scenarios[name];
if (scenario === undefined || link === undefined) {
  console.error(`usage: page.mjs ${Object.keys(scenarios).join("|")} LINK`);
  process.exit(2);
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: FLAGS });
const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
page.setDefaultTimeout(PATIENCE_MS);
// As on a later visit, the guide is closed and covers no button.
if (!SEES_GUIDE.includes(name)) {
  await page.addInitScript((demos) => {
    if (location.protocol === "about:") return;
    for (const demo of demos) localStorage.setItem(`robocell-guide-${demo}`, "closed");
  }, DEMOS);
}
const errors = [];
page.on("console", (message) => {
  if (message.type() === "error") errors.push(message.text());
});
page.on("pageerror", (error) => errors.push(String(error)));
page.on("dialog", (dialog) => {
  errors.push(`a dialog: ${dialog.message()}`);
  void dialog.dismiss();
});

const test = {
  page,
  /** The page without its token. */
  home: link.split("?")[0],
  robocell,
  /** The value of `look` on the page, which gets `window.robocell`. */
  look: (look, arg) => page.evaluate(`(${look})(window.robocell, ${JSON.stringify(arg ?? null)})`),
  /** Waits until `look` is true on the page. */
  until: async (what, look, arg) => {
    const condition = `(${look})(window.robocell, ${JSON.stringify(arg ?? null)})`;
    // Asked from here: the page's policy forbids to evaluate text within it.
    for (const since = Date.now(); Date.now() - since < PATIENCE_MS; ) {
      if (await page.evaluate(condition)) return;
      await page.waitForTimeout(50);
    }
    throw new Error(`timed out waiting until ${what}`);
  },
  same: (what, found, expected) => {
    if (JSON.stringify(found) !== JSON.stringify(expected)) {
      throw new Error(`${what} is ${JSON.stringify(found)}, not ${JSON.stringify(expected)}`);
    }
  },
  near: (what, found, expected, within) => {
    const off = Math.hypot(...expected.map((x, axis) => x - found[axis]));
    if (!(off <= within)) {
      throw new Error(`${what} is at ${found}, ${off} m from ${expected}`);
    }
  },
  /** Presses the button whose command-line twin is `twin`. */
  press: async (twin) => {
    const button = page.locator(`button:visible[title*="$ ${twin}"]`).first();
    await button.click();
  },
  /** What a restart makes the browser say is no mistake of the page. */
  forgive: (pattern) => {
    const kept = errors.filter((error) => !pattern.test(error));
    errors.splice(0, errors.length, ...kept);
  },
};

try {
  await page.goto(link);
  await test.until("the page shows the cell", (r) => r?.settled());
  const said = await scenario(test);
  test.same("what the console complains about", errors, []);
  console.log(`${name}: ${said ?? "ok"}`);
} catch (error) {
  console.error(`${name}: ${error.message}`);
  if (errors.length > 0) console.error(`console: ${errors.join("\n")}`);
  process.exitCode = 1;
  console.error(
    JSON.stringify(
      await page.evaluate(
        "({ task: window.robocell?.store.status?.task, flags: window.robocell?.store.snapshot?.flags })",
      ),
    ),
  );
  if (process.env.PAGE_SHOT !== undefined) await page.screenshot({ path: process.env.PAGE_SHOT });
} finally {
  await browser.close();
}
