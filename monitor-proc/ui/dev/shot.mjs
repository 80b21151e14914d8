// A picture or a film of the page, taken by Chromium without a window.
//
//   node dev/shot.mjs LINK OUT.png [time=S] [view=FRAGMENT] [size=WxH]
//   node dev/shot.mjs LINK OUT.mp4|OUT.gif from=S to=S [fps=12] [speed=1] [part=page|view] ...
//
// LINK is the link that `robocell run` prints; it may have the port of `npm run dev`. A moment is
// shown out of the flight recorder: let the cell run, or `robocell step` it, that far first. CHROMIUM
// names the browser; a film needs ffmpeg.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { extname } from "node:path";
import { chromium } from "playwright-core";

// A browser without a GPU draws the first picture slowly.
const PATIENCE_MS = 60_000;
// A scene has few colours, and each of a GIF costs room.
const GIF =
  "split[a][b];[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=none:diff_mode=rectangle";
const CODECS = {
  ".gif": ["-vf", GIF],
  // H.264 has even sizes only.
  ".mp4": ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-crf", "26"],
};

const [link, out, ...words] = process.argv.slice(2);
const given = Object.fromEntries(words.map((word) => [word.split("=", 1)[0], word.slice(word.indexOf("=") + 1)]));
const { time, view, size = "1280x720", from = "0.1", to, fps = "12", speed = "1", part = "page" } = given;
const codec = out === undefined ? undefined : CODECS[extname(out)];
const [width, height] = size.split("x").map(Number);
if (out === undefined || (codec !== undefined) !== (to !== undefined) || !(width > 0 && height > 0)) {
  console.error(
    "usage: shot.mjs LINK OUT.png [time=S], or shot.mjs LINK OUT.mp4|OUT.gif from=S to=S; see its first lines",
  );
  process.exit(2);
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
  ],
});
const page = await browser.newPage({ viewport: { width, height } });
page.on("console", (message) => message.type() === "error" && console.error(message.text()));
page.on("pageerror", (error) => console.error(error.stack));

/** Polls from here: the policy of the page forbids to evaluate text within it. */
async function until(what, look, arg) {
  for (const since = Date.now(); Date.now() - since < PATIENCE_MS; await page.waitForTimeout(20)) {
    if (await page.evaluate(look, arg)) return;
  }
  throw new Error(`timed out waiting for ${what}; the page: ${(await page.innerText("body")).slice(0, 300)}`);
}

/** Shows a moment of the past, and waits until it has been drawn. */
async function seek(time_s) {
  await page.evaluate((time_s) => window.robocell.store.send({ do: "seek", time_s }), time_s);
  await until(`${time_s} s`, (at) => Math.abs(window.robocell.store.snapshot.time - at) < 0.05, time_s);
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
}

async function film() {
  const clip = part === "view" ? await page.locator("#view").boundingBox() : undefined;
  const input = ["-y", "-loglevel", "error", "-f", "image2pipe", "-framerate", fps, "-i", "-"];
  const encoder = spawn("ffmpeg", [...input, ...codec, out], { stdio: ["pipe", "inherit", "inherit"] });
  const ended = once(encoder, "exit");
  for (let at = Number(from); at <= Number(to); at += Number(speed) / Number(fps)) {
    await seek(at);
    if (!encoder.stdin.write(await page.screenshot({ clip }))) await once(encoder.stdin, "drain");
  }
  encoder.stdin.end();
  const [code] = await ended;
  if (code !== 0) throw new Error(`ffmpeg ended with ${code}`);
}

try {
  // The first of a name counts: `view` may set another quality.
  const fragment = [view, (time ?? to) === undefined ? undefined : `t=${time ?? from}`, "quality=0", "shot"];
  await page.goto(`${link}#${fragment.filter((each) => each !== undefined).join("&")}`, { timeout: PATIENCE_MS });
  await until("the page", () => window.robocell?.settled());
  if (codec !== undefined) await film();
  else await page.screenshot({ path: out });
  console.log(`${out}: ${width} x ${height}`);
} finally {
  await browser.close();
}
