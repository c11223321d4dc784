// The report in a real browser: no error, controls change pixels, tables sort, plots are there, keys do what they say.
//
// node report.js FOLDER SCREENSHOTS, with the browser's path in CHROMIUM.

import assert from 'node:assert/strict';
import { readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { open, pixels as pixelsOf } from './page.js';

const [folder, shots] = process.argv.slice(2);
const whole = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
// What is tested of one sensor is of the first.
const report = whole.sensors[0];
const { page, said, asked, test, close } = await open(folder, shots);
const pixels = (pane) => pixelsOf(page, pane);
const shown = (row) => page.waitForFunction((i) => document.querySelector('article').dataset.shown === String(i), row);
const first = '[data-pane=truth] .pane';

/** Something done must change the panes named, and only those. */
async function changes(panes, act) {
  const all = ['truth', 'run', 'map'];
  const before = await Promise.all(all.map(pixels));
  await act();
  const after = await Promise.all(all.map(pixels));
  assert.deepEqual(all.filter((_, i) => before[i] !== after[i]), panes);
}

const last = report.rows.length - 1;

await test('the page is below 15 MB', () => assert.ok(statSync(join(folder, 'index.html')).size < 15e6));

await test('the summary has a line for each row of report.json, with its error', async () => {
  const lines = await page.locator('#rows tbody tr').allInnerTexts();
  assert.equal(lines.length, report.rows.length);
  report.rows.forEach((row, i) => assert.ok(lines[i].includes(row.label), lines[i]));
});

await test('the answers come first, one a curve', async () => {
  const answers = await page.locator('#answers dd').allInnerTexts();
  assert.deepEqual(answers, report.answers.map((answer) => answer.sentences.join(' ')));
});

await test('the summary sorts by error, up and down', async () => {
  const order = () => page.locator('#rows tbody tr').evaluateAll((lines) => lines.map((line) => Number(line.dataset.row)));
  const expected = report.rows.map((row, i) => [row.error, i]).sort(([a], [b]) => a - b).map(([, i]) => i);
  const errors = (rows) => rows.map((i) => report.rows[i].error);
  await page.click('#rows th:nth-child(2) button');
  assert.deepEqual(errors(await order()), errors(expected));
  assert.equal(await page.getAttribute('#rows th:nth-child(2)', 'aria-sort'), 'ascending');
  await page.click('#rows th:nth-child(2) button');
  assert.deepEqual(errors(await order()), errors(expected.reverse()));
  await page.screenshot({ path: join(shots, 'summary.png') });
});

await test('a row is chosen by the keyboard, and everything follows it', async () => {
  await page.focus(`#rows tr[data-row="${last}"]`);
  await page.keyboard.press('Enter');
  await shown(last);
  assert.equal(await page.innerText('#figures .chosen'), report.rows[last].label);
  assert.equal(await page.inputValue('[data-control=run]'), String(last));
  assert.equal(await page.locator('#layers tbody tr').count(), report.rows[last].comparison.layers.length);
});

await test('exposure changes all panes, colours and scale those of light, the map its own', async () => {
  const set = (control, value) => () => page.selectOption(`[data-control=${control}]`, value);
  await changes(['truth', 'run', 'map'], () => page.locator('[data-control=exposure]').fill('2'));
  await changes(['truth', 'run'], set('colours', 'grey'));
  await changes(['truth', 'run'], set('scale', 'linear'));
  await changes(['map'], set('map', 'difference'));
  await changes(['map'], set('map', 'z'));
  await page.locator('#where').screenshot({ path: join(shots, 'where.png') });
  await set('colours', 'light')();
  await set('scale', 'log')();
  await page.locator('[data-control=exposure]').fill('0');
});

await test('wheel, drag and keys move all panes together, and a double click fits', async () => {
  const start = await Promise.all(['truth', 'run', 'map'].map(pixels));
  const middle = async () => {
    await page.locator(first).scrollIntoViewIfNeeded();
    const box = await page.locator(first).boundingBox();
    return [box.x + box.width / 2, box.y + box.height / 2];
  };
  await page.mouse.move(...await middle());
  // A pane that is not in focus lets the page scroll.
  await changes([], () => page.mouse.wheel(0, 40).then(() => page.waitForTimeout(200)));
  await page.focus(first);
  const centre = await middle();
  await page.mouse.move(...centre);
  await changes(['truth', 'run', 'map'], () => page.mouse.wheel(0, -600).then(() => page.waitForTimeout(100)));
  await changes(['truth', 'run', 'map'], async () => {
    await page.mouse.down();
    await page.mouse.move(centre[0] + 60, centre[1] + 40);
    await page.mouse.up();
  });
  await page.focus(first);
  await changes(['truth', 'run', 'map'], () => page.keyboard.press('ArrowLeft'));
  await changes(['truth', 'run', 'map'], () => page.keyboard.press('+'));
  await page.dblclick(first);
  assert.deepEqual(await Promise.all(['truth', 'run', 'map'].map(pixels)), start);
});

await test('the wipe shows the run beside the truth in one pane, and its blade moves', async () => {
  await page.focus(first);
  await page.keyboard.press('w');
  assert.equal(await page.locator('[data-pane=run]').isHidden(), true);
  assert.equal(await page.getAttribute('[data-control=wipe]', 'aria-pressed'), 'true');
  const before = await pixels('truth');
  await page.keyboard.press('[');
  await page.keyboard.press('[');
  assert.notEqual(await pixels('truth'), before);
  await page.locator('#where').screenshot({ path: join(shots, 'wipe.png') });
  await page.keyboard.press('w');
});

await test('the texel under the pointer is told with the values of report.json', async () => {
  const { worst } = report.rows[last].comparison.layers.find((layer) => layer.layer === report.rows[last].layer).difference;
  await page.locator(first).scrollIntoViewIfNeeded();
  const box = await page.locator(first).boundingBox();
  const [width, height] = report.size;
  await page.mouse.move(box.x + ((worst.x + 0.5) / width) * box.width, box.y + ((worst.y + 0.5) / height) * box.height);
  const text = (await page.innerText('#readout')).replaceAll('−', '-');
  assert.ok(text.includes(`texel (${worst.x}, ${worst.y})`), text);
  const [truth, run] = [/truth (\S+)/, new RegExp(`${report.rows[last].label.replace(/[^\w ]/g, '\\$&')}\\s+(\\S+)`)].map((find) => Number(text.match(find)[1]));
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  // Four digits are shown, of 12 bits.
  assert.ok(Math.abs(truth / mean(worst.reference) - 1) < 1e-3, text);
  assert.ok(Math.abs(run / mean(worst.other) - 1) < 1e-3, text);
  assert.ok(text.includes('±'), text);
});

await test('the plot has a mark for each row, tells it at the pointer, and follows the cost', async () => {
  const known = report.rows.filter((row) => row.error > 0).length;
  assert.equal(await page.locator('#plot .mark-point').count(), known);
  const mark = page.locator(`#plot .mark-point[data-row="${last}"]`);
  await mark.hover();
  assert.ok((await page.innerText('#tip')).includes(report.rows[last].label));
  // The dearest row may be so by rays and by seconds: its mark then stays at the axis' end.
  const places = () => page.locator('#plot .mark-point').evaluateAll((marks) => marks.map((one) => one.getAttribute('cx')));
  const before = await places();
  await page.selectOption('#cost-axis', 'seconds');
  assert.equal(await page.locator('#plot .mark-point').count(), known);
  assert.notDeepEqual(await places(), before);
  await page.locator('#cost').screenshot({ path: join(shots, 'cost.png') });
  await page.locator('#plot .mark-point[data-row="0"]').focus();
  await page.keyboard.press('Enter');
  await shown(0);
});

await test('the plot has the errors of the light that is chosen, and those rows only that are judged by it', async () => {
  const light = page.locator('[data-control=light]').first();
  const before = await light.inputValue();
  await light.selectOption('E');
  assert.equal(await page.locator('#plot .mark-point').count(), report.rows.filter((row) => row.layer === 'E').length);
  await light.selectOption(before);
});

await test('ledger, histogram, record and commands are there', async () => {
  assert.equal(await page.locator('#histogram .bin').count(), 20);
  // Approximations keep no ledger.
  const kept = report.rows.findIndex((row) => row.facts?.ledger);
  await page.locator(`#plot .mark-point[data-row="${kept}"]`).focus();
  await page.keyboard.press('Enter');
  await shown(kept);
  assert.equal(await page.locator('#ledger tbody tr').count(), report.rows[kept].facts.ledger.rows.length);
  assert.equal(await page.locator('#waterfalls table tbody tr').count(), report.stages[0].stages.length);
  assert.ok((await page.innerText('#environment')).includes(whole.study.scene_hash));
  assert.ok((await page.innerText('#commands')).includes(report.rows[last].command));
});

await test('it is dark where the reader wants it so, and has no controls in print', async () => {
  const paper = () => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
  const light = await paper();
  await page.emulateMedia({ colorScheme: 'dark' });
  assert.notEqual(await paper(), light);
  await page.screenshot({ path: join(shots, 'dark.png'), fullPage: true });
  await page.emulateMedia({ colorScheme: 'light', media: 'print' });
  assert.equal(await page.locator('nav').isHidden(), true);
  await page.pdf({ path: join(shots, 'print.pdf'), format: 'A4' });
  await page.emulateMedia({ media: 'screen' });
});

await test('nothing is wider than a telephone', async () => {
  await page.setViewportSize({ width: 400, height: 800 });
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${overflow} pixels`);
});

await test('nothing went wrong and nothing was asked of a network', () => {
  assert.deepEqual(said, []);
  assert.deepEqual(asked.filter((url) => !/^(file|data|blob):/.test(url)), []);
});

await close();
