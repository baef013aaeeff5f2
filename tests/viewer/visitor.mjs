// A person before the service's page, in a Chromium without a window.
import { chromium } from 'playwright-core';

export const LIMIT = 150000;

const FLAGS = [
  '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

export class Visitor {
  // request: { "chromium": PATH, "page": URL, "token": TEXT }; what the pages complain of, and what they load from elsewhere, is kept.
  static async come(request) {
    const visitor = new Visitor();
    visitor.browser = await chromium.launch({ executablePath: request.chromium, headless: true, args: FLAGS, timeout: LIMIT });
    return Object.assign(visitor, { request, complaints: [], outside: [] });
  }

  // A page of that size, signed in.
  async open(size, scale = 1) {
    const page = await (await this.browser.newContext({ viewport: size, deviceScaleFactor: scale })).newPage();
    page.setDefaultTimeout(LIMIT);
    page.on('pageerror', (error) => this.complaints.push(String(error)));
    page.on('console', (line) => {
      if (line.text().includes('GL Driver Message (OpenGL, Performance')) return;
      if (['error', 'warning'].includes(line.type())) this.complaints.push(line.text());
    });
    page.on('request', (sent) => {
      if (!sent.url().startsWith(this.request.page) && !/^(blob|data):/.test(sent.url())) this.outside.push(sent.url());
    });
    await page.goto(this.request.page);
    await page.getByLabel('Token').fill(this.request.token);
    await page.getByRole('button', { name: 'Sign in' }).click();
    await page.getByRole('heading', { name: 'Scenes' }).waitFor();
    return page;
  }

  leave() {
    return this.browser.close();
  }
}

export async function upload(page, file) {
  await page.getByLabel('Scene to upload').setInputFiles(file);
  await page.getByRole('button', { name: 'Upload', exact: true }).click();
  await page.getByRole('button', { name: 'Compute' }).or(page.locator('#said.bad')).waitFor();
  if (!(await page.getByRole('button', { name: 'Compute' }).count())) throw new Error(await page.locator('#said').innerText());
}

// request: { "error": PER CENT, "density": LUMELS PER METRE, "requirement": KEY, "time": SECONDS, "surfaces": NAMES }
export async function order(page, request) {
  await page.getByLabel('Standard error in per cent').fill(String(request.error));
  if (request.time) await page.getByLabel('Seconds at most').fill(String(request.time));
  await page.getByLabel('Lumels per metre').fill(String(request.density));
  await page.getByLabel('Requirement').fill(request.requirement);
  if (request.surfaces) await page.getByText('Lux maps of all surfaces').click();
  for (const name of request.surfaces ?? []) {
    await page.getByRole('group', { name: 'Surfaces of which lux maps are computed' }).getByLabel(name, { exact: true }).check();
  }
  await page.getByRole('button', { name: 'Compute' }).click();
}

export async function change(page, label, value) {
  await page.getByLabel(label, { exact: true }).fill(value);
  await page.getByLabel(label, { exact: true }).press('Tab');
}

// What the page says at points [[x, y], ...], in shares of the first room's picture, of each room.
export async function probe(page, points) {
  const told = [];
  for (const [x, y] of points) {
    const frame = await page.locator('.room canvas').first().boundingBox();
    await page.mouse.move(frame.x + x * frame.width, frame.y + y * frame.height);
    told.push(await page.locator('.probe').evaluateAll((all) => all.map((each) => [each.textContent, each.title])));
  }
  return told;
}
