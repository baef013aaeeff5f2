// Takes the guide's pictures of the service's page: a room, what is changed of it, and both designs side by side.
//   node pictures.mjs REQUEST.json
// REQUEST: as for page.mjs, but "lights": NAMES that are given the "spectrum": NAME, of which the "dimmed": NAMES are at 60 %, and
//   "material": [NAME, TITLE of what comes in its place]
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { change, order, probe, upload, Visitor } from './visitor.mjs';

const request = JSON.parse(await readFile(process.argv[2], 'utf8'));
const visitor = await Visitor.come(request);
const picture = (page, name) => page.screenshot({ path: join(request.pictures, `service_${name}.png`) });

// Longest time for lux maps. [ms]
const BAKED = 400000;

// The room is drawn a moment after it is there. [ms]
const DRAWN = 1500;

try {
  const page = await visitor.open({ width: 1280, height: 800 });
  await upload(page, request.file);
  await order(page, request);
  await page.getByRole('button', { name: 'Walk', exact: true }).waitFor({ timeout: BAKED });
  await page.getByRole('button', { name: 'Walk', exact: true }).click();
  await page.locator('.room canvas').waitFor();
  await page.locator('#interval').fill(String(request.interval));
  await page.locator('#interval').press('Enter');
  await page.waitForTimeout(DRAWN);
  await probe(page, request.points);
  await picture(page, 'room');

  await page.getByRole('button', { name: 'Scenes', exact: true }).click();
  await page.getByRole('button', { name: 'Open', exact: true }).click();
  await page.locator('#scene table').waitFor();
  for (const name of request.lights) await page.getByLabel(`spectrum of ${name}`, { exact: true }).selectOption(`cie ${request.spectrum}`);
  for (const name of request.dimmed) await change(page, `dimming of ${name}`, '0.6');
  await page.getByLabel('Material', { exact: true }).selectOption({ label: request.material[0] });
  await page.getByLabel('Material in its place').selectOption({ label: request.material[1] });
  await page.getByRole('button', { name: 'Replace' }).click();
  await page.getByText(`${request.material[0]} → ${request.material[1]}`).waitFor();
  await picture(page, 'edits');
  await order(page, request);
  await page.getByRole('button', { name: /^Beside/ }).first().waitFor({ timeout: BAKED });
  await page.getByRole('button', { name: /^Beside/ }).first().click();
  await page.locator('.room canvas').nth(1).waitFor();
  await page.waitForTimeout(DRAWN);
  await probe(page, request.points);
  await picture(page, 'beside');

  const phone = await visitor.open({ width: 390, height: 844 });
  await phone.getByRole('button', { name: 'Jobs', exact: true }).click();
  await phone.getByRole('button', { name: 'Walk', exact: true }).last().click();
  await phone.locator('.room canvas').waitFor();
  await phone.waitForTimeout(DRAWN);
  await probe(phone, request.points);
  await picture(phone, 'phone');
} finally {
  await visitor.leave();
}
