// Opens a page in Chromium and tells what is on it, as JSON: node test/look.mjs CHROMIUM URL SCREENSHOT [dark]
// A page of the daemon's is asked for its first answer; a still one shows its own.

import { chromium } from "playwright-core";

const [executablePath, url, screenshot, scheme] = process.argv.slice(2);
const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const browser = await chromium.launch({ executablePath, args });
const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: scheme ?? "light" });
const page = await context.newPage();
const said = [];
const asked = [];
page.on("console", (message) => message.type() === "error" && said.push(message.text()));
page.on("pageerror", (error) => said.push(String(error)));
page.on("request", (request) => asked.push(request.url()));
await page.goto(url);

let live = null;
if (url.startsWith("http")) {
  await page.waitForSelector("#running li");
  await page.waitForSelector("#answers button");
  live = await page.locator("#live").innerText();
  await page.locator("#answers button").first().click();
}
await page.waitForFunction(() => window.taut?.picture && document.getElementById("where").textContent);

const shown = await page.evaluate(() => {
  const { taut } = window;
  const { stage, after, before, picture } = taut;
  const links = () => Object.fromEntries(Object.entries(stage.robot.links).map(([name, link]) => [name, [...link.matrixWorld.elements]]));
  const joints = () => Object.fromEntries(Object.entries(stage.robot.joints).map(([name, joint]) => [name, [...joint.jointValue]]));
  const begin = taut.position;
  const marked = { position: begin, highlighted: [...(stage.highlighted ?? [])], label: document.querySelector("#labels .bad")?.textContent ?? null,
    inks: stage.kept.map((mark) => mark.ink.color.getHexString()) };
  const at = picture.result.path.map((_, i) => {
    taut.go(after.position(Math.max(0, i - 1), i === 0 ? 0 : 1));
    return { position: taut.position, slider: Number(document.getElementById("slider").value), joints: joints(), links: links() };
  });
  const traces = stage.traces.map(({ userData: { kind, tip, waypoints } }) => ({ kind, tip, waypoints: waypoints.map((point) => point.toArray()) }));
  const placed = ({ position, quaternion }) => [...position.toArray(), ...quaternion.toArray()];
  const kept = stage.kept.map((mark) => ({ name: mark.name, region: placed(mark.region), watched: placed(mark.watched),
    solids: mark.sight.solids.length, trails: mark.trails.children.length }));
  const objects = stage.obstacles.map((object) => ({ name: object.name, carriedBy: object.parent.urdfName ?? null, pose: [...object.matrixWorld.elements] }));
  taut.go(begin);
  if (marked.label) taut.mark(picture.result);
  return { marked, at, traces, kept, objects, length: [before.length, after.length], verdict: document.querySelector(".verdict").textContent,
    contacts: stage.contactMarks.map((mark) => mark.userData.contact.names), plots: document.querySelectorAll("#panel svg").length };
});

// By the keyboard, as somebody without a mouse: the slider moves the robot, space plays and stops.
await page.locator("#slider").focus();
await page.keyboard.press(shown.marked.position < 1 ? "End" : "Home");
const moved = await page.evaluate(() => window.taut.position);
await page.keyboard.press(" ");
const plays = await page.evaluate(() => window.taut.running);
await page.keyboard.press(" ");
await page.evaluate((position) => {
  window.taut.run(false);
  window.taut.go(position);
  if (window.taut.picture.result.reason) window.taut.mark(window.taut.picture.result);
}, shown.marked.position);
await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const unlabelled = await page.evaluate(() =>
  [...document.querySelectorAll("button, input, select, canvas")].filter((control) =>
    !(control.ariaLabel || control.labels?.length || control.textContent.trim())).map((control) => control.outerHTML));

// How much of the stage has which colour.
const stage = await page.locator("#stage").screenshot();
await page.screenshot({ path: screenshot });
const painter = await context.newPage();
const colors = await painter.evaluate(async (png) => {
  const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
  const canvas = new OffscreenCanvas(image.width, image.height);
  const brush = canvas.getContext("2d");
  brush.drawImage(image, 0, 0);
  const { data } = brush.getImageData(0, 0, image.width, image.height);
  const count = { green: 0, red: 0, violet: 0, tan: 0, grey: 0, all: image.width * image.height, different: 0 };
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = data.slice(i, i + 3);
    // The ground of the stage counts for nothing.
    if (Math.abs(r - data[0]) + Math.abs(g - data[1]) + Math.abs(b - data[2]) <= 24) continue;
    count.different++;
    if (g > r * 1.15 && g > b * 1.15) count.green++;
    else if (r > g * 1.6 && r > b * 1.6) count.red++;
    else if (r > b * 1.25 && g > b * 1.1) count.tan++;
    else if (b > r * 1.08 && r > g * 1.08) count.violet++;
    else if (Math.max(r, g, b) - Math.min(r, g, b) < 22 && r < 225) count.grey++;
  }
  return count;
}, stage.toString("base64"));
await browser.close();
console.log(JSON.stringify({ ...shown, moved, plays, live, said, asked, unlabelled, colors }));
