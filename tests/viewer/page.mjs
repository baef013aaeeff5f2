// Uses the service's page as a person does, in a Chromium without a window.
//   node page.mjs REQUEST.json > REPORT.json
// REQUEST: { "chromium": PATH, "page": URL, "token": TEXT, "file": PATH, "error": PER CENT, "density": LUMELS PER METRE,
//   "requirement": KEY, "interval": LUX, "material": TITLE, "points": [[x, y] in shares of the room's picture], "pictures": FOLDER }
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { change, order, probe, upload, Visitor } from './visitor.mjs';

const request = JSON.parse(await readFile(process.argv[2], 'utf8'));
const visitor = await Visitor.come(request);
const report = { complaints: visitor.complaints, outside: visitor.outside };

const picture = (page, name) => page.screenshot({ path: join(request.pictures, `${name}.png`) });

// All kinds of edits, one of them refused; what the page shows of them once the scene is opened anew.
async function edit(page) {
  const spectrum = page.getByLabel('spectrum of Lamp', { exact: true });
  await change(page, 'temperature of Lamp', '3000');
  await spectrum.selectOption('cie LED-B3');
  await page.waitForFunction(() => document.querySelector('[aria-label="temperature of Lamp"]').value === '');
  const file = page.getByLabel('file of the spectrum of Lamp');
  await file.setInputFiles({ name: 'broken.csv', mimeType: 'text/csv', buffer: Buffer.from('400 1\n500 dark\n') });
  await page.locator('#said.bad').waitFor();
  const refused = [await page.locator('#said').innerText(), await spectrum.inputValue()];
  await file.setInputFiles({ name: 'lamp.csv', mimeType: 'text/csv', buffer: Buffer.from('nm,cold,warm\n400,1,1\n700,1,3\n') });
  await change(page, 'column of the spectrum of Lamp', '2');
  await page.getByLabel('Material', { exact: true }).selectOption('Black');
  await page.getByLabel('Material in its place').selectOption({ label: request.material });
  await page.getByRole('button', { name: 'Replace' }).click();
  await page.getByText(`Black → ${request.material}`).waitFor();
  await page.getByRole('button', { name: 'As it was' }).click();
  await page.getByText(`Black → ${request.material}`).waitFor({ state: 'detached' });
  await page.getByText('None is hidden').click();
  await page.getByRole('group', { name: 'Objects that are there' }).getByLabel('Screen').uncheck();
  await page.getByText('Hidden: Screen').waitFor();
  await page.getByRole('button', { name: 'Open', exact: true }).click();
  await page.getByText('Hidden: Screen').waitFor();
  const shown = await Promise.all([
    spectrum.locator('option:checked').innerText(), page.getByLabel('column of the spectrum of Lamp').inputValue(),
    page.getByLabel('dimming of Lamp').inputValue(), page.getByLabel('temperature of Lamp').inputValue(),
  ]);
  return { refused, shown };
}

try {
  const page = await visitor.open({ width: 1280, height: 800 });
  await upload(page, request.file);
  await picture(page, 'scene');
  await order(page, request);
  await page.getByRole('button', { name: 'Walk', exact: true }).waitFor();
  await picture(page, 'jobs');
  await page.getByRole('button', { name: 'Walk', exact: true }).click();
  await page.locator('.room canvas').waitFor();
  report.before = await probe(page, request.points);
  await picture(page, 'room');

  const slider = page.locator('#panel input[type=range]').first();
  report.groups = await page.locator('#panel input[type=range]').count();
  await slider.fill('0.5');
  report.dimmed = await probe(page, request.points);
  await slider.fill('1');
  report.restored = await probe(page, request.points);
  await page.locator('#interval').fill(String(request.interval));
  await page.locator('#interval').press('Enter');
  await picture(page, 'isolux');
  report.table = await page.locator('#panel section:not(.verdicts) table').first().innerText();
  report.verdicts = await page.locator('#panel .verdicts tbody tr').allInnerTexts();

  const focus = page.locator('.room canvas').first();
  await focus.click({ position: { x: 10, y: 10 } });
  for (let i = 0; i < 5; i += 1) await page.keyboard.press('w');
  report.walked = await probe(page, request.points);

  // A second design: the same with its lamps at half, beside the first.
  await page.getByRole('button', { name: 'Scenes', exact: true }).click();
  await page.getByRole('button', { name: 'Open', exact: true }).click();
  await change(page, 'dimming of Lamp', '0.5');
  await page.getByText('changes are kept').waitFor();
  report.edits = await edit(page);
  await picture(page, 'edits');
  await order(page, request);
  await page.getByRole('button', { name: /^Beside/ }).first().waitFor();
  await page.getByRole('button', { name: /^Beside/ }).first().click();
  await page.locator('.room canvas').nth(1).waitFor();
  report.beside = await probe(page, request.points);
  report.panelTitles = await page.locator('#panel h3').allInnerTexts();
  report.titles = await page.locator('.room .title').allInnerTexts();
  await picture(page, 'beside');

  const phone = await visitor.open({ width: 390, height: 844 });
  const fits = () => phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
  await phone.getByRole('button', { name: 'Open', exact: true }).click();
  await phone.locator('#scene table').waitFor();
  report.phone = [await fits()];
  await picture(phone, 'phone_scene');
  await phone.getByRole('button', { name: 'Jobs', exact: true }).click();
  await phone.getByRole('button', { name: 'Walk', exact: true }).first().click();
  await phone.locator('.room canvas').waitFor();
  report.phone.push(await fits());
  await picture(phone, 'phone');
} finally {
  await visitor.leave();
}
process.stdout.write(JSON.stringify(report));
