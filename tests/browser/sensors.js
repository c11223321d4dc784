// A report of several sensors, in colour: a part for each, which has its own run, its own viewer, and names of its own.
//
// node sensors.js FOLDER SCREENSHOTS, with the browser's path in CHROMIUM.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { open, pixels } from './page.js';

const [folder, shots] = process.argv.slice(2);
const report = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
const { page, said, asked, test, close } = await open(folder, shots);
const camera = report.sensors.findIndex((sensor) => sensor.sensor === 'camera');
const part = page.locator('article').nth(camera);

await test('each sensor has its part, and a way to it', async () => {
  assert.equal(await page.locator('article').count(), report.sensors.length);
  for (const [i, { sensor, rows }] of report.sensors.entries()) {
    const own = page.locator('article').nth(i);
    assert.equal(await own.locator('header h2').innerText(), sensor);
    assert.equal(await own.locator('[data-part=rows] tbody tr').count(), rows.length);
    const link = await page.locator('#links a', { hasText: sensor }).getAttribute('href');
    assert.equal(await own.locator('header').getAttribute('id'), link.slice(1));
  }
});

await test('no two elements have one name', async () => {
  const twice = await page.evaluate(() => {
    const ids = [...document.querySelectorAll('[id]')].map((node) => node.id);
    return ids.filter((id, i) => ids.indexOf(id) !== i);
  });
  assert.deepEqual(twice, []);
});

await test('a run is chosen on its own sensor only', async () => {
  const before = await page.locator('article').evaluateAll((parts) => parts.map((one) => one.dataset.shown));
  const other = (Number(before[camera]) + 1) % report.sensors[camera].rows.length;
  await part.locator(`tr[data-row="${other}"]`).click();
  await page.waitForFunction(([at, row]) => document.querySelectorAll('article')[at].dataset.shown === String(row), [camera, other]);
  const after = await page.locator('article').evaluateAll((parts) => parts.map((one) => one.dataset.shown));
  assert.deepEqual(after, before.map((row, i) => (i === camera ? String(other) : row)));
});

await test('a film with colours is shown in them, by exposure and scale', async () => {
  const shown = () => pixels(page, 'run', camera);
  const set = (control, value) => part.locator(`[data-control=${control}]`).selectOption(value);
  const colourful = () => part.locator('[data-pane=truth] canvas:not(.marks)').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let [red, green] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      red += data[i] > data[i + 1] + 30;
      green += data[i + 1] > data[i] + 30;
    }
    return [red, green];
  });
  await set('colours', 'rgb');
  await set('scale', 'linear');
  const before = await shown();
  await part.locator('[data-control=exposure]').fill('3');
  const brighter = await shown();
  assert.notEqual(brighter, before);
  // The box has a red wall and a green one, each a tenth of the picture and more.
  const [red, green] = await colourful();
  assert.ok(red > 1000 && green > 1000, `${red} red and ${green} green pixels`);
  await part.locator('[data-part=where]').screenshot({ path: join(shots, 'colour.png') });
  await set('scale', 'log');
  assert.notEqual(await shown(), brighter);
  await part.locator('[data-part=where]').screenshot({ path: join(shots, 'colour-log.png') });
});

await test('nothing went wrong and nothing was asked of a network', async () => {
  await page.screenshot({ path: join(shots, 'sensors.png'), fullPage: true });
  assert.deepEqual(said, []);
  assert.deepEqual(asked.filter((url) => !/^(file|data|blob):/.test(url)), []);
});

await close();
