// Looks at the page in a browser: node dev/shot.mjs QUERY OUT.png [WAIT_MS]
import { chromium } from "playwright-core";

const [query = "?demo&still", out = "shot.png", wait = "2500"] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--no-first-run",
  ],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
page.on("console", (message) => console.log(message.type(), message.text()));
page.on("pageerror", (error) => console.log("pageerror", error.stack));
await page.goto(`${process.env.PAGE ?? "http://localhost:5199/dev/alone.html"}${query}`, { timeout: 120_000 });
await page.waitForTimeout(Number(wait));
if (process.env.SHOW) console.log(JSON.stringify(await page.evaluate(process.env.SHOW)));
await page.screenshot({ path: out, timeout: 120_000 });
await browser.close();
