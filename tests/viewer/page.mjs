// Uses the service's page as a person does, in a Chromium without a window.
//   node page.mjs REQUEST.json > REPORT.json
// REQUEST: { "chromium": PATH, "page": URL, "token": TEXT, "file": PATH, "error": PER CENT, "density": LUMELS PER METRE,
//   "requirement": KEY, "interval": LUX, "material": TITLE, "points": [[x, y] in shares of the room's picture], "pictures": FOLDER }
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const LIMIT = 150000;

const FLAGS = [
  '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

const request = JSON.parse(await readFile(process.argv[2], 'utf8'));
const browser = await chromium.launch({ executablePath: request.chromium, headless: true, args: FLAGS, timeout: LIMIT });
const report = { complaints: [], outside: [] };

async function open(size) {
  const page = await (await browser.newContext({ viewport: size })).newPage();
  page.setDefaultTimeout(LIMIT);
  page.on('pageerror', (error) => report.complaints.push(String(error)));
  page.on('console', (line) => {
    if (line.text().includes('GL Driver Message (OpenGL, Performance')) return;
    if (['error', 'warning'].includes(line.type())) report.complaints.push(line.text());
  });
  page.on('request', (sent) => {
    if (!sent.url().startsWith(request.page) && !/^(blob|data):/.test(sent.url())) report.outside.push(sent.url());
  });
  await page.goto(request.page);
  await page.getByLabel('Token').fill(request.token);
  await page.getByRole('button', { name: 'Sign in' }).click();
  await page.getByRole('heading', { name: 'Scenes' }).waitFor();
  return page;
}

const picture = (page, name) => page.screenshot({ path: join(request.pictures, `${name}.png`) });

async function order(page) {
  await page.getByLabel('Standard error in per cent').fill(String(request.error));
  await page.getByLabel('Lumels per metre').fill(String(request.density));
  await page.getByLabel('Requirement').fill(request.requirement);
  await page.getByRole('button', { name: 'Compute' }).click();
}

// All kinds of edits, one of them refused; what the page shows of them once the scene is opened anew.
async function edit(page) {
  const spectrum = page.getByLabel('spectrum of Lamp', { exact: true });
  await page.getByLabel('temperature of Lamp').fill('3000');
  await page.getByLabel('temperature of Lamp').press('Tab');
  await spectrum.selectOption('cie LED-B3');
  await page.waitForFunction(() => document.querySelector('[aria-label="temperature of Lamp"]').value === '');
  const file = page.getByLabel('file of the spectrum of Lamp');
  await file.setInputFiles({ name: 'broken.csv', mimeType: 'text/csv', buffer: Buffer.from('400 1\n500 dark\n') });
  await page.locator('#said.bad').waitFor();
  const refused = [await page.locator('#said').innerText(), await spectrum.inputValue()];
  await file.setInputFiles({ name: 'lamp.csv', mimeType: 'text/csv', buffer: Buffer.from('nm,cold,warm\n400,1,1\n700,1,3\n') });
  await page.getByLabel('column of the spectrum of Lamp').fill('2');
  await page.getByLabel('column of the spectrum of Lamp').press('Tab');
  await page.getByLabel('Material', { exact: true }).selectOption('Black');
  await page.getByLabel('Material in its place').selectOption({ label: request.material });
  await page.getByRole('button', { name: 'Replace' }).click();
  await page.getByText(`Black → ${request.material}`).waitFor();
  await page.getByRole('button', { name: 'As it was' }).click();
  await page.getByText(`Black → ${request.material}`).waitFor({ state: 'detached' });
  await page.getByText('None is hidden').click();
  await page.getByLabel('Screen').uncheck();
  await page.getByText('Hidden: Screen').waitFor();
  await page.getByRole('button', { name: 'Open', exact: true }).click();
  await page.getByText('Hidden: Screen').waitFor();
  const shown = await Promise.all([
    spectrum.locator('option:checked').innerText(), page.getByLabel('column of the spectrum of Lamp').inputValue(),
    page.getByLabel('dimming of Lamp').inputValue(), page.getByLabel('temperature of Lamp').inputValue(),
  ]);
  return { refused, shown };
}

// What the page says at points of each room.
async function probe(page) {
  const told = [];
  for (const [x, y] of request.points) {
    const frame = await page.locator('.room canvas').first().boundingBox();
    await page.mouse.move(frame.x + x * frame.width, frame.y + y * frame.height);
    told.push(await page.locator('.probe').evaluateAll((all) => all.map((each) => [each.textContent, each.title])));
  }
  return told;
}

try {
  const page = await open({ width: 1280, height: 800 });
  await page.getByLabel('Scene to upload').setInputFiles(request.file);
  await page.getByRole('button', { name: 'Upload', exact: true }).click();
  await page.getByRole('button', { name: 'Compute' }).or(page.locator('#said.bad')).waitFor();
  if (!(await page.getByRole('button', { name: 'Compute' }).count())) throw new Error(await page.locator('#said').innerText());
  await picture(page, 'scene');
  await order(page);
  await page.getByRole('button', { name: 'Walk', exact: true }).waitFor();
  await picture(page, 'jobs');
  await page.getByRole('button', { name: 'Walk', exact: true }).click();
  await page.locator('.room canvas').waitFor();
  report.before = await probe(page);
  await picture(page, 'room');

  const slider = page.locator('#panel input[type=range]').first();
  report.groups = await page.locator('#panel input[type=range]').count();
  await slider.fill('0.5');
  report.dimmed = await probe(page);
  await slider.fill('1');
  report.restored = await probe(page);
  await page.locator('#interval').fill(String(request.interval));
  await page.locator('#interval').press('Enter');
  await picture(page, 'isolux');
  report.table = await page.locator('#panel section:not(.verdicts) table').first().innerText();
  report.verdicts = await page.locator('#panel .verdicts tbody tr').allInnerTexts();

  const focus = page.locator('.room canvas').first();
  await focus.click({ position: { x: 10, y: 10 } });
  for (let i = 0; i < 5; i += 1) await page.keyboard.press('w');
  report.walked = await probe(page);

  // A second design: the same with its lamps at half, beside the first.
  await page.getByRole('button', { name: 'Scenes', exact: true }).click();
  await page.getByRole('button', { name: 'Open', exact: true }).click();
  await page.getByLabel(/^dimming of/).first().fill('0.5');
  await page.getByLabel(/^dimming of/).first().press('Tab');
  await page.getByText('changes are kept').waitFor();
  report.edits = await edit(page);
  await picture(page, 'edits');
  await order(page);
  await page.getByRole('button', { name: /^Beside/ }).first().waitFor();
  await page.getByRole('button', { name: /^Beside/ }).first().click();
  await page.locator('.room canvas').nth(1).waitFor();
  report.beside = await probe(page);
  report.panelTitles = await page.locator('#panel h3').allInnerTexts();
  report.titles = await page.locator('.room .title').allInnerTexts();
  await picture(page, 'beside');

  const phone = await open({ width: 390, height: 844 });
  await phone.getByRole('button', { name: 'Jobs', exact: true }).click();
  await phone.getByRole('button', { name: 'Walk', exact: true }).first().click();
  await phone.locator('.room canvas').waitFor();
  report.phone = await phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
  await picture(phone, 'phone');
} finally {
  await browser.close();
}
process.stdout.write(JSON.stringify(report));
