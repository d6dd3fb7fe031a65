// Plays an exported body in headless Chromium, without a graphics card, and writes points and pictures.
//
// usage: node play.mjs BODY.glb REQUEST.json FOLDER
//        node play.mjs BODY.glb                            (serves the page, for a browser)
//
// REQUEST.json: {times: [seconds ...], pictures: [{file, seconds, view}, ...]}, with view as in player.js. The files in FOLDER
// are points.f32 (float32, times by vertices by 3, in Blender's axes), report.json and the pictures.

import chromium from "@sparticuz/chromium";
import { readFile, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import puppeteer from "puppeteer-core";

const [body, requestFile, folder] = process.argv.slice(2);
const here = fileURLToPath(new URL(".", import.meta.url));
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".glb": "model/gltf-binary" };

function fileOf(path) {
  if (path === "/body.glb") return body;
  const inside = normalize(path).replace(/^(\.\.[/\\])+/, "");
  return inside.startsWith("/three/") ? join(here, "node_modules", inside) : join(here, inside);
}

// The Chromium of the npm package is for Linux on x86-64. On other systems, CHROMIUM names another one.
async function start() {
  const executablePath = process.env.CHROMIUM ?? (await chromium.executablePath());
  try {
    return await puppeteer.launch({ args: chromium.args, executablePath, headless: "shell" });
  } catch (error) {
    console.error(
      `${executablePath} did not start. On Debian, install its libraries (apt-get install libnss3 libgbm1), or a Chromium ` +
        "(apt-get install chromium), and set CHROMIUM=/usr/bin/chromium",
    );
    throw error;
  }
}

const server = createServer(async (request, response) => {
  const { pathname } = new URL(request.url, "http://localhost");
  try {
    const content = await readFile(fileOf(pathname));
    response.writeHead(200, { "content-type": TYPES[extname(pathname)] ?? "application/octet-stream" }).end(content);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((ready) => server.listen(requestFile ? 0 : 8000, "127.0.0.1", ready));
const address = `http://127.0.0.1:${server.address().port}/player.html`;

if (!requestFile) {
  console.log(`${address} plays ${body}. Press Ctrl+C to stop.`);
} else {
  const request = JSON.parse(await readFile(requestFile));
  const browser = await start();
  const messages = [];
  async function open(view) {
    const page = await browser.newPage();
    page.on("console", (message) => ["error", "warn"].includes(message.type()) && messages.push(message.text()));
    page.on("pageerror", (error) => messages.push(String(error)));
    await page.setViewport({ width: view.width, height: view.height });
    await page.goto(`${address}?view=${encodeURIComponent(JSON.stringify(view))}`);
    await page.waitForFunction("window.isReady", { timeout: 120_000 });
    return page;
  }
  const page = await open(request.pictures[0].view);
  const points = [];
  for (const seconds of request.times) points.push(...(await page.evaluate((at) => window.pointsAt(at), seconds)));
  await writeFile(join(folder, "points.f32"), Buffer.from(new Float32Array(points).buffer));
  const report = await page.evaluate(() => window.report);
  await page.close();
  for (const picture of request.pictures) {
    const shown = await open(picture.view);
    await shown.evaluate((at) => window.show(at), picture.seconds);
    await shown.screenshot({ path: join(folder, picture.file) });
    await shown.close();
  }
  await writeFile(join(folder, "report.json"), JSON.stringify({ ...report, browser: await browser.version(), messages }));
  await browser.close();
  server.close();
}
