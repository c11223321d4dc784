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
// Rows whose error in some light is known: techniques model some of it only.
const inLight = (light) => report.rows.filter((row) => [light, 'E'].includes(row.layer)
  && row.comparison.layers.some((one) => one.layer === light && one.fidelity.l1?.value > 0));

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
  await page.click('#rows th:nth-child(3) button');
  assert.deepEqual(errors(await order()), errors(expected));
  assert.equal(await page.getAttribute('#rows th:nth-child(3)', 'aria-sort'), 'ascending');
  await page.click('#rows th:nth-child(3) button');
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
  const known = inLight(await page.inputValue('#cost [data-control=light]')).length;
  assert.ok(known > 0);
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

await test('the cost plot follows the figure that is chosen', async () => {
  const places = () => page.locator('#plot .mark-point').evaluateAll((marks) => marks.map((one) => one.getAttribute('cy')));
  const before = await places();
  await page.selectOption('#cost [data-control=figure]', 'displaced');
  assert.notDeepEqual(await places(), before);
  assert.ok((await page.innerText('#plot')).includes('displaced [texels]'));
  await page.selectOption('#cost [data-control=figure]', 'l1');
  assert.deepEqual(await places(), before);
});

await test('a figure that is chosen in one section is shown in all', async () => {
  const choices = page.locator('article').first().locator('[data-control=figure]');
  const gauges = () => page.locator('#rows .bar').evaluateAll((bars) => bars.map((one) => one.getAttribute('width')));
  const before = await gauges();
  // Summary, cost, and each technique's stages.
  const count = await choices.count();
  assert.equal(count, 2 + report.stages.length);
  const names = [['l2', 'L2', 'L2'], ['misplaced', 'misplaced', 'misplaced'], ['energy', '|energy − 1|', 'energy'], ['displaced', 'displaced [texels]', 'displaced'], ['l1', 'L1', 'L1']];
  for (const [i, [figure, name, word]] of names.entries()) {
    await choices.nth(i % count).selectOption(figure);
    assert.deepEqual(await choices.evaluateAll((all) => all.map((one) => one.value)), Array(count).fill(figure));
    assert.ok((await page.innerText('#plot')).includes(name), name);
    const told = await page.locator('#waterfalls p').first().innerText();
    assert.ok(told.startsWith(`${word} `), told);
    if (figure !== 'l1') assert.notDeepEqual(await gauges(), before, figure);
  }
  assert.deepEqual(await gauges(), before);
});

await test('stages add up to the figure that is chosen, with their signs', async () => {
  const [one] = report.stages;
  for (const { figure, whole, residual, stages } of one.figures) {
    const sum = stages.reduce((all, { value }) => all + value, residual);
    assert.ok(Math.abs(sum - whole) < 1e-12 * Math.max(1, Math.abs(whole)), figure);
    await page.selectOption('#stages [data-control=figure]', figure);
    assert.equal(await page.locator('#waterfalls svg').first().locator('rect').count(), stages.length + 2);
  }
  await page.selectOption('#stages [data-control=figure]', 'energy');
  assert.ok((await page.locator('#waterfalls svg').first().textContent()).includes('−'), 'light that is lost has a sign');
  await page.selectOption('#stages [data-control=figure]', 'l1');
  await page.locator('#stages').screenshot({ path: join(shots, 'stages.png') });
});

await test('the flux of an approximation is told stage by stage, and adds up to its energy', async () => {
  const [row] = report.rows;
  const { stage_flux: entries } = row.facts;
  assert.ok(entries.length > 1);
  // What is left of the flux, by the energy, is the truth's: the same for all rows of one light. Films are f32.
  const fluxes = report.rows.filter((one) => one.facts?.stage_flux && one.layer === row.layer).map((one) => {
    const { energy } = one.comparison.layers.find((layer) => layer.layer === one.layer).fidelity;
    return one.facts.stage_flux.reduce((sum, { flux }) => sum + flux, 0) / energy.value;
  });
  assert.ok(fluxes.length > 1 && fluxes.every((flux) => Math.abs(flux / fluxes[0] - 1) < 1e-7), fluxes.join());
  // The image, and the truth beside it.
  assert.equal(await page.locator('#stage-flux rect').count(), entries.length + 2);
  await page.locator('#flux').screenshot({ path: join(shots, 'flux.png') });
});

await test('L2 against scale has a curve for each run of the light that is chosen', async () => {
  const { layer } = report.rows[0];
  const alike = report.rows.filter((row) => row.layer === layer).length;
  assert.equal(await page.locator('#scales .curve').count(), alike);
  await page.locator('#scales').screenshot({ path: join(shots, 'scales.png') });
});

await test('a click tells the profile through a texel, along a row or a column', async () => {
  await page.locator(first).scrollIntoViewIfNeeded();
  const box = await page.locator(first).boundingBox();
  const [width, height] = report.size;
  const [x, y] = [0.3, 0.7];
  await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
  const title = () => page.innerText('#profile');
  await page.waitForFunction((text) => document.querySelector('#profile').textContent.includes(text), `along row ${Math.floor(y * height)}`);
  await page.selectOption('[data-control=profile]', 'column');
  await page.waitForFunction((text) => document.querySelector('#profile').textContent.includes(text), `along column ${Math.floor(x * width)}`);
  assert.ok((await title()).includes('truth'));
  assert.equal(await page.locator('#profile .band').count(), 1);
  await page.selectOption('[data-control=profile]', 'row');
  await page.locator('#profile').screenshot({ path: join(shots, 'profile.png') });
});

await test('a region that is dragged has figures of all runs of its light, by hand the same', async () => {
  await page.dblclick(first);
  const box = await page.locator(first).boundingBox();
  await page.keyboard.down('Shift');
  await page.mouse.move(box.x + 1, box.y + 1);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width - 1, box.y + box.height - 1);
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await page.waitForSelector('#region table');
  const lines = await page.locator('#region tbody tr').allInnerTexts();
  const alike = report.rows.filter((row) => row.layer === report.rows[0].layer);
  assert.equal(lines.length, alike.length + 1);
  // The whole film: the figures of report.json, from films of 12 bits.
  alike.forEach((row, i) => {
    const { energy } = row.comparison.layers.find((layer) => layer.layer === row.layer).fidelity;
    const shown = Number(lines[i + 1].split('\t')[2].replace(' %', '')) / 100;
    // Three digits are shown.
    const isShown = (text, value) => Math.abs(text - value) <= 6e-3 * Math.abs(value);
    assert.ok(isShown(shown, energy.value), lines[i + 1]);
    const l1 = Number(lines[i + 1].split('\t')[3].replace(' %', '')) / 100;
    assert.ok(isShown(l1, row.error), lines[i + 1]);
  });
});

await test('profile and region can be had by the keyboard', async () => {
  await page.focus(first);
  await page.keyboard.press('0');
  await page.keyboard.press('x');
  const [, height] = report.size;
  await page.waitForFunction((text) => document.querySelector('#profile').textContent.includes(text), `along row ${height / 2}`);
  await page.keyboard.press('r');
  await page.waitForFunction((text) => document.querySelector('#region').textContent.includes(text), `${report.size.join(' × ')} texels at (0, 0)`);
});

await test('the run flips into the truth’s place, and runs can be held against each other', async () => {
  await changes(['truth'], () => page.click('[data-control=flip]'));
  assert.equal(await page.innerText('[data-pane=truth] b'), report.rows[0].label);
  await page.click('[data-control=flip]');
  const other = report.rows.findIndex((row, i) => i > 0 && row.layer === report.rows[0].layer);
  await page.selectOption('[data-control=against]', String(other));
  await page.waitForFunction((text) => document.querySelector('[data-pane=truth] b').textContent === text, report.rows[other].label);
  await page.selectOption('[data-control=against]', '');
  await page.waitForFunction(() => document.querySelector('[data-pane=truth] b').textContent === 'truth');
});

await test('single layers of truth and run can be seen', async () => {
  const photons = report.rows.findIndex((row) => row.layer === 'E');
  await page.selectOption('[data-control=run]', String(photons));
  await shown(photons);
  const layers = await page.locator('[data-control=layer] option').evaluateAll((options) => options.map(({ value }) => value));
  assert.ok(layers.includes('LD') && layers.includes('LTTD'), layers.join());
  await changes(['truth', 'run', 'map'], async () => {
    await page.selectOption('[data-control=layer]', 'LD');
    await page.waitForTimeout(300);
  });
  await page.selectOption('[data-control=layer]', '');
  await page.selectOption('[data-control=run]', '0');
  await shown(0);
});

await test('maps of FLIP and of the truth’s bar are there', async () => {
  for (const map of ['flip', 'relativeBar']) await changes(['map'], () => page.selectOption('[data-control=map]', map));
  assert.equal(await page.innerText('[data-pane=map] b'), 'the truth’s bar by its value');
  await page.selectOption('[data-control=map]', 'relative');
});

await test('plots, tables and insets can be saved', async () => {
  const saved = async (act) => {
    const [download] = await Promise.all([page.waitForEvent('download'), act()]);
    return [download.suggestedFilename(), readFileSync(await download.path())];
  };
  const [svg, text] = await saved(() => page.locator('#cost [data-export=SVG]').click());
  assert.ok(svg.endsWith('.svg') && text.toString().startsWith('<svg') && text.toString().includes('stroke'));
  const png = Buffer.from([0x89, 0x50, 0x4e, 0x47]);
  const [, plot] = await saved(() => page.locator('#waterfalls [data-export=PNG]').first().click());
  assert.deepEqual(plot.subarray(0, 4), png);
  const [, inset] = await saved(() => page.click('[data-control=inset]'));
  assert.deepEqual(inset.subarray(0, 4), png);
  const latex = await page.evaluate(() => asLatex(document.querySelector('#rows')));
  assert.equal(latex.split('\n').length, report.rows.length + 4);
  assert.ok(/^[\x00-\x7f]*$/.test(latex), latex);
  assert.ok(latex.includes('$\\times$ 10$^{'), latex);
  const markdown = await page.evaluate(() => asMarkdown(document.querySelector('#rows')));
  assert.equal(markdown.split('\n').length, report.rows.length + 2);
});

await test('a link leads back to the view', async () => {
  await page.selectOption('[data-control=map]', 'difference');
  await page.focus(first);
  await page.keyboard.press('+');
  await page.selectOption('[data-control=run]', String(last));
  await page.selectOption('#summary [data-control=figure]', 'misplaced');
  await shown(last);
  const seen = await Promise.all(['truth', 'run', 'map'].map(pixels));
  const hash = await page.evaluate(() => (document.querySelector('[data-control=link]').click(), location.hash));
  const address = page.url();
  await page.goto('about:blank');
  await page.goto(address.split('#')[0] + hash);
  await shown(last);
  await page.waitForFunction(() => document.querySelector('[data-control=map]').value === 'difference');
  await page.waitForTimeout(300);
  assert.deepEqual(await Promise.all(['truth', 'run', 'map'].map(pixels)), seen);
  assert.equal(await page.locator('#stages [data-control=figure]').first().inputValue(), 'misplaced');
  await page.selectOption('#summary [data-control=figure]', 'l1');
  await page.dblclick(first);
  await page.selectOption('[data-control=map]', 'relative');
  await page.evaluate(() => { location.hash = ''; });
  await page.selectOption('[data-control=run]', '0');
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
  assert.equal(await page.locator('#waterfalls table').first().locator('tbody tr').count(), report.stages[0].stages.length);
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
