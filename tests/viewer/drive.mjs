// Holds files against Khronos' validator and shows them in a Chromium without a window.
//   node drive.mjs REQUEST.json > REPORT.json
// REQUEST: { "validate": [PATH], "chromium": PATH, "page": URL, "views": [what viewer.js's show() takes] }
import { readFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import validator from 'gltf-validator';
import { chromium } from 'playwright-core';

const LIMIT = 60000;

const FLAGS = [
  '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

async function validate(path) {
  const { issues, info } = await validator.validateBytes(new Uint8Array(await readFile(path)), {
    uri: path,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(join(dirname(path), decodeURIComponent(uri)))),
  });
  return { errors: issues.numErrors, warnings: issues.numWarnings, messages: issues.messages, info };
}

async function look(request) {
  const browser = await chromium.launch({
    executablePath: request.chromium, headless: true, args: FLAGS, timeout: LIMIT,
  });
  try {
    const page = await browser.newPage();
    const complaints = [];
    page.setDefaultTimeout(LIMIT);
    page.on('pageerror', (error) => complaints.push(String(error)));
    page.on('console', (line) => {
      // That reading pixels takes time is known.
      if (line.text().includes('GL Driver Message (OpenGL, Performance')) return;
      if (['error', 'warning'].includes(line.type())) complaints.push(line.text());
    });
    page.on('requestfailed', (failed) => complaints.push(`not loaded: ${failed.url()}`));
    await page.goto(request.page);
    await page.waitForFunction('window.ready === true');
    const views = [];
    for (const view of request.views) {
      views.push(await page.evaluate((what) => window.show(what), view));
    }
    return { views, complaints };
  } finally {
    await browser.close();
  }
}

const request = JSON.parse(await readFile(process.argv[2], 'utf8'));
const files = [];
for (const path of request.validate) files.push(await validate(path));
process.stdout.write(JSON.stringify({ files, ...(await look(request)) }));
