// Pulls a cube and moves the gizmo with the mouse, and prints the commands sent.
import { chromium } from "playwright-core";

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-background-networking", "--no-first-run"],
});
const page = await browser.newPage({ viewport: { width: 800, height: 500 } });
page.setDefaultTimeout(120_000);
const said = [];
page.on("console", (message) => said.push(message.text()));
page.on("pageerror", (error) => console.log("pageerror", error.stack));
await page.goto("http://localhost:5199/dev/alone.html?demo&still&held#quality=5", { timeout: 120_000 });
await page.waitForFunction(() => window.robocell?.view.bodyPositions().red_cube !== undefined);
await page.waitForTimeout(3000);
const at = (name) => page.evaluate((one) => window.robocell.view.screenOf(one), name);
const tell = (what) => {
  console.log(what, said.splice(0).filter((line) => line.startsWith("{")).map((line) => line.slice(0, 160)));
};
const camera = () => page.evaluate(() => location.hash);

const [x, y] = await at("red_cube");
await page.keyboard.down("Shift");
await page.mouse.move(x, y);
await page.mouse.down();
for (let step = 1; step <= 6; step++) {
  await page.mouse.move(x + 10 * step, y - 5 * step);
  await page.waitForTimeout(50);
}
await page.mouse.wheel(0, -300);
await page.waitForTimeout(900);
tell("drag");
await page.screenshot({ path: "/tmp/touch.png" });
await page.keyboard.press("Escape");
await page.waitForTimeout(500);
said.length = 0;
await page.waitForTimeout(500);
tell("after escape");
await page.mouse.up();
await page.keyboard.up("Shift");

const [gx, gy] = await at("gizmo z");
await page.mouse.move(gx - 3, gy + 3);
await page.mouse.move(gx, gy);
await page.mouse.down();
for (let step = 1; step <= 6; step++) {
  await page.mouse.move(gx, gy - 8 * step);
  await page.waitForTimeout(60);
}
await page.mouse.up();
await page.waitForTimeout(300);
tell("gizmo");
await page.evaluate(() => window.robocell.view.gizmoMode("rotate"));
await page.waitForTimeout(300);
console.log("camera stays", JSON.stringify(await camera()));
const [bx, by] = await at("blue_cube");
await page.mouse.click(bx, by);
await page.waitForTimeout(300);
console.log("selected", await page.evaluate(() => window.robocell.view.selection.name));
await page.mouse.move(60, 400);
await page.mouse.down();
await page.mouse.move(120, 420);
await page.mouse.up();
await page.waitForTimeout(800);
console.log("camera moved", await camera());
for (const preset of [2, 3, 4, 5, 1]) {
  await page.evaluate((number) => window.robocell.view.camera(number), preset);
  await page.waitForTimeout(800);
  console.log(preset, await camera());
  await page.screenshot({ path: `/tmp/preset${preset}.png` });
}
await browser.close();
