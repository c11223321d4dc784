// The page: tables from the figures, and one chosen run that all sections follow.

const data = JSON.parse(document.getElementById('data').textContent);
const { report, timings } = data;
const { study, truth, rows, curves } = report;
const place = (id) => document.getElementById(id);
const colourOf = (name) => `var(--c${curves.findIndex((curve) => curve.name === name) % 6})`;
const judged = (row) => row.comparison.layers.find((layer) => layer.layer === row.layer);
const counter = (row, name) => row.facts?.counters.find((one) => one.name === name)?.count ?? null;
const truthLabel = timings.truth.label;
let chosen = 0;

// The curve of light in a coffee cup, which the program is named after: as in every cup, from its own formula.
place('nephroid').setAttribute('d', Array.from({ length: 121 }, (_, i) => {
  const t = (Math.PI * i) / 60;
  return `${i ? 'L' : 'M'}${((3 * Math.sin(t) - Math.sin(3 * t)) / 2).toFixed(3)} ${((3 * Math.cos(t) - Math.cos(3 * t)) / 2).toFixed(3)}`;
}).join(''));

place('title').textContent = `${study.scene.replace(/^.*[\\/]/, '').replace(/\.xml$/, '')}, ${study.sensor}`;
place('subtitle').textContent = `${study.quantity} [${study.unit}] on ${study.size.join(' × ')} ${study.quantity === 'radiance' ? 'pixels' : 'texels'}; truth by ${truthLabel}`;

function notices() {
  const list = [...report.warnings];
  for (const gate of report.gates) {
    if (gate.verdict !== 'kept') {
      list.push(`Limit of ${percent(gate.limit)} on ${gate.name}: ${gate.verdict}; its error is ${percent(gate.error)}.`);
    }
  }
  for (const row of rows) {
    for (const check of row.checks) list.push(`${row.label}: ${check.message}.`);
    for (const warning of row.facts?.warnings ?? []) if (!list.includes(warning)) list.push(warning);
  }
  if (!truth.facts.complete) list.push('The truth did not reach the error asked for.');
  if (list.length) {
    place('notices').hidden = false;
    place('notices').append(element('ul', {}, ...list.map((text) => element('li', {}, text))));
  }
}

function lead() {
  const own = truth.facts.own_error === null ? 'does not know its own error' : `is known to ${percent(truth.facts.own_error, 2)} (its own figure)`;
  const best = rows.filter((row) => row.resolved).sort((a, b) => a.error - b.error)[0];
  const kept = report.gates.filter((gate) => gate.verdict === 'kept').map((gate) => `${gate.name} keeps its limit of ${percent(gate.limit)}.`);
  place('lead').textContent = [
    `The truth, ${truthLabel}, ${own}${timings.truth.median ? `, and took ${number(timings.truth.median, 3)} s` : ''}.`,
    best ? `Least error that it resolves: ${percent(best.error)}, by ${best.label}.` : 'It resolves no run here.',
    ...kept,
  ].join(' ');
}

/** A bar for an error on a logarithmic scale over all rows, with a tick where the truth's own error is. */
function gauge(row, [low, high]) {
  const part = (value) => 100 * Math.min(1, Math.max(0.01, Math.log(value / low) / Math.log(high / low)));
  if (!(row.error > 0)) return '';
  return drawn('svg', { class: 'gauge', viewBox: '0 0 100 10', preserveAspectRatio: 'none', 'aria-hidden': 'true', style: `color: ${colourOf(row.name)}` },
    drawn('rect', { width: 100, height: 10 }), drawn('rect', { class: 'bar', width: part(row.error), height: 10 }),
    row.truth_error > 0 ? drawn('line', { x1: part(row.truth_error), x2: part(row.truth_error), y1: 0, y2: 10, 'vector-effect': 'non-scaling-stroke' }) : null);
}

/**
 * A table whose columns sort: [{ title, unit, value: row => number or text, show: row => node or text, text }]
 */
function sortable(table, columns, items, { onrow } = {}) {
  const body = element('tbody');
  const order = items.map((item, i) => ({ item, i }));
  const lines = new Map(order.map(({ item, i }) => [i, line(item, i)]));
  function line(item, i) {
    const cells = columns.map(({ show, text }) => element('td', { class: text ? 'text' : null }, show(item, i)));
    return onrow ? onrow(element('tr', {}, ...cells), item, i) : element('tr', {}, ...cells);
  }
  const heads = columns.map((column) => element('th', { class: column.text ? 'text' : null, scope: 'col', 'aria-sort': 'none' },
    column.value ? element('button', { type: 'button', onclick: () => sort(column) }, column.title) : column.title,
    column.unit ? element('span', { class: 'unit' }, ` ${column.unit}`) : null));
  function sort(column) {
    const head = heads[columns.indexOf(column)];
    const up = head.getAttribute('aria-sort') !== 'ascending';
    heads.forEach((one) => one.setAttribute('aria-sort', 'none'));
    head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
    const key = ({ item, i }) => column.value(item, i);
    order.sort((a, b) => {
      const [left, right] = [key(a), key(b)];
      // What is not known is last, either way.
      if (left === null || right === null) return (left === null) - (right === null);
      const sign = typeof left === 'string' ? left.localeCompare(right, 'en', { numeric: true }) : left - right;
      return up ? sign : -sign;
    });
    body.replaceChildren(...order.map(({ i }) => lines.get(i)));
  }
  body.replaceChildren(...lines.values());
  table.replaceChildren(element('thead', {}, element('tr', {}, ...heads)), body);
}

function summary() {
  const errors = rows.flatMap((row) => [row.error, row.truth_error]).filter((value) => value > 0);
  const range = [Math.min(...errors) / 1.5, Math.max(...errors) * 1.1];
  const figure = (title, value, show, unit) => ({ title, unit, value: (row) => value(row) ?? null, show: (row) => show(value(row)) });
  const columns = [
    { title: 'run', text: true, value: (row) => row.label, show: (row) => element('span', {}, element('span', { class: 'dot', style: `background: ${colourOf(row.name)}` }), row.label) },
    { title: 'error', value: (row) => row.error, show: (row) => element('span', { class: row.resolved ? null : 'muted' }, percent(row.error)) },
    { title: '', show: (row) => gauge(row, range) },
    figure('bias', (row) => row.bias, (value) => signedPercent(value, 2)),
    figure('energy', (row) => judged(row)?.difference.energy_ratio, (value) => number(value, 6)),
    figure('SSIM', (row) => judged(row)?.similarity?.ssim, (value) => number(value, 4)),
    figure('FLIP', (row) => judged(row)?.flip?.mean, (value) => number(value, 3)),
    figure('rays', (row) => counter(row, 'rays'), (value) => number(value, 3)),
    { title: 'time', unit: 's', value: (_, i) => timings.rows[i].median, show: (_, i) => time(timings.rows[i]) },
    { title: 'front', value: (row) => (row.pareto.rays ? 0 : 1), show: (row) => (row.pareto.rays ? '●' : '') },
    { title: '', text: true, show: (row) => element('span', {}, ...remarks(row)) },
  ];
  sortable(place('rows'), columns, rows, {
    onrow: (line, _, i) => filled(line, {
      tabindex: 0, 'data-row': i, 'aria-selected': 'false', onclick: () => choose(i),
      onkeydown: (event) => {
        if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); choose(i); }
        if (event.key === 'ArrowDown') { event.preventDefault(); line.nextElementSibling?.focus(); }
        if (event.key === 'ArrowUp') { event.preventDefault(); line.previousElementSibling?.focus(); }
      },
    }, []),
  });
}

function time({ median, seconds }) {
  if (median === null) return '–';
  const spread = seconds.length > 1 ? element('span', { class: 'muted' }, ` (${number(Math.min(...seconds), 3)}–${number(Math.max(...seconds), 3)})`) : null;
  return element('span', {}, number(median, 3), spread);
}

function remarks(row) {
  const said = row.checks.map((check) => element('span', { class: 'alarm', title: check.message }, `${check.kind}? `));
  if (!row.resolved) said.push(element('span', { class: 'muted', title: `the truth's own error is ${percent(row.truth_error)}` }, 'not resolved '));
  if (row.facts && !row.facts.complete) said.push(element('span', { class: 'alarm' }, 'incomplete '));
  if (row.layer !== (study.quantity === 'radiance' ? 'L' : 'E')) said.push(element('span', { class: 'muted' }, `${row.layer} only`));
  return said;
}

const viewer = new Viewer(data, place('panes'), place('readout'));

function controls() {
  const { state } = viewer;
  const choice = (name, key, options) => {
    const select = element('select', { 'data-control': key, onchange: (event) => viewer.set({ [key]: event.target.value }) },
      ...options.map(([value, text]) => element('option', { value, selected: state[key] === value }, text)));
    return element('label', {}, name, select);
  };
  const slider = element('input', { type: 'range', min: -8, max: 12, step: 0.5, value: 0, 'data-control': 'exposure', oninput: (event) => viewer.set({ exposure: Number(event.target.value) }) });
  const stops = element('output', {}, '0 stops');
  const wipe = element('button', { type: 'button', 'data-control': 'wipe', 'aria-pressed': 'false', onclick: () => viewer.set({ wipe: !state.wipe }) }, 'Wipe');
  const select = element('select', { 'data-control': 'run', onchange: (event) => choose(Number(event.target.value)) },
    ...rows.map((row, i) => element('option', { value: i }, row.label)));
  document.querySelector('#where .controls').append(
    element('label', {}, 'Run', select), choice('Map', 'map', Object.entries(MAPS).map(([key, map]) => [key, map.name])),
    choice('Colours', 'colours', [['light', 'false colour'], ['grey', 'grey']]), choice('Scale', 'scale', [['log', 'logarithmic'], ['linear', 'linear']]),
    element('label', {}, 'Exposure', slider, stops), wipe, element('button', { type: 'button', 'data-control': 'fit', onclick: () => viewer.fit() }, 'Fit'),
  );
  const follow = () => {
    wipe.setAttribute('aria-pressed', state.wipe);
    slider.value = state.exposure;
    stops.textContent = `${state.exposure > 0 ? '+' : ''}${number(state.exposure, 2)} stops`;
  };
  place('panes').addEventListener('viewer', follow);
  place('panes').addEventListener('turn', (event) => choose((chosen + event.detail + rows.length) % rows.length));
  const reduced = data.step > 1 ? `Pictures are means of ${data.step} × ${data.step} texels; the films beside this page have all. ` : '';
  place('precision').textContent = `${reduced}Channels are averaged; bars are one standard error, or half the distance of bounds. Read-outs have 4 digits; the films have all.`;
}

function cost() {
  const select = place('cost-axis');
  if (!select.options.length) {
    const names = [...new Set(rows.flatMap((row) => row.facts?.counters.map((one) => one.name) ?? []))];
    select.append(...names.map((name) => element('option', { value: name }, name)), element('option', { value: 'seconds' }, 'seconds'));
    select.addEventListener('change', cost);
  }
  const axis = select.value;
  const of = (i) => (axis === 'seconds' ? timings.rows[i].median : counter(rows[i], axis));
  const own = (curve) => rows[curve.rows[0]].facts?.counters.at(-1)?.name;
  const lines = curves.map((curve) => ({
    name: curve.name,
    colour: colourOf(curve.name),
    // In the cost shown, and in what the method itself counts: photons, samples.
    orders: curve.orders.filter((one) => one.cost === axis || one.cost === own(curve)),
    points: curve.rows.filter((i) => of(i) > 0 && rows[i].error > 0).sort((a, b) => of(a) - of(b)).map((i) => ({
      row: i, cost: of(i), error: rows[i].error, bar: rows[i].truth_error ?? 0, resolved: rows[i].resolved,
      label: `${rows[i].label}\nerror ${percent(rows[i].error)} ± ${percent(rows[i].truth_error, 2)}${rows[i].resolved ? '' : ', not resolved'}\n${number(of(i), 4)} ${axis}`,
    })),
  }));
  const front = new Set(rows.map((_, i) => i).filter((i) => (axis === 'seconds' ? timings.rows[i].pareto : rows[i].pareto[axis])));
  // What has an error and no such cost, as a film from elsewhere, is a level.
  const levels = rows.map((row, i) => ({ row: i, name: row.label, error: row.error, colour: colourOf(row.name) })).filter((level) => !(of(level.row) > 0) && level.error > 0);
  costPlot(place('plot'), { curves: lines, levels, axis, front, chosen, choose });
}

function figures(row) {
  const { layers } = row.comparison;
  const figure = (title, value, show = (it) => number(it, 4), unit) => ({ title, unit, value: (it) => value(it) ?? null, show: (it) => show(value(it)) });
  sortable(place('layers'), [
    { title: 'layer', text: true, value: (it) => it.layer, show: (it) => it.layer },
    figure('mean of truth', (it) => it.difference.mean_reference, undefined, study.unit),
    figure('mean', (it) => it.difference.mean_other, undefined, study.unit),
    figure('bias', (it) => it.equivalence.bias.relative, (it) => signedPercent(it, 3)),
    figure('error', (it) => it.difference.relative_rmse, percent),
    figure('unexplained', (it) => it.equivalence.texels.unexplained, percent),
    figure('relMSE', (it) => it.difference.rel_mse),
    figure('SMAPE', (it) => it.difference.smape),
    figure('95 %', (it) => it.difference.percentiles.find((one) => one.percent === 95)?.value, undefined, study.unit),
    figure('SSIM', (it) => it.similarity?.ssim),
    figure('FLIP', (it) => it.flip?.mean),
    { title: `within ${percent(study.margin)}`, text: true, value: (it) => it.equivalence.verdict, show: (it) => it.equivalence.verdict },
  ], layers);
  const layer = judged(row);
  histogram(place('histogram'), layer?.significance);
  const worst = layer?.difference.worst;
  const items = worst ? [
    ['largest difference', `${number(worst.difference)} ${study.unit} at texel (${worst.x}, ${worst.y})`],
    ['truth there', worst.reference.map((value) => number(value)).join(', ')],
    ['run there', worst.other.map((value) => number(value)).join(', ')],
    ['bias', layer.equivalence.bias.interval ? `between ${layer.equivalence.bias.interval.map((it) => signedPercent(it)).join(' and ')}` : '–'],
    ['verdict', `${layer.equivalence.verdict} within ${percent(study.margin)} (bias ${layer.equivalence.bias.verdict}, texels ${layer.equivalence.texels.verdict})`],
    ['own error', row.facts ? percent(row.facts.own_error) : 'not told'],
    ['truth’s error', percent(row.truth_error)],
  ] : [];
  place('verdict').replaceChildren(...items.flatMap(([term, text]) => [element('dt', {}, term), element('dd', {}, text)]));
  if (row.comparison.notes.length) place('verdict').append(element('dt', {}, 'notes'), element('dd', {}, row.comparison.notes.join('; ')));
}

function ledger(row) {
  const table = row.facts?.ledger;
  if (!table) {
    place('flux-lead').textContent = row.facts ? 'This method keeps no ledger on this sensor.' : 'A film from elsewhere has no ledger.';
    place('ledger').replaceChildren();
    return;
  }
  const isByDifference = table.elsewhere !== null;
  place('flux-lead').textContent = `Of ${number(table.emitted, 6)} W that were traced${isByDifference
    ? `, ${number(table.elsewhere, 5)} W ended elsewhere, by difference: only what is received was followed.`
    : `; the ledger closes to ${number(table.closure_error, 2)}.`}`;
  const flux = (title, key) => ({ title, unit: 'W', value: (it) => it[key], show: (it) => (it[key] === 0 ? '·' : number(it[key], 5)) });
  const fates = isByDifference ? [] : [flux('direct', 'direct'), flux('escaped', 'escaped'), flux('absorbed', 'absorbed'), flux('cut off', 'cut_off')];
  sortable(place('ledger'), [{ title: 'after', text: true, value: (it) => it.after, show: (it) => it.after }, flux('received', 'received'), ...fates], table.rows);
}

function record() {
  const threads = [...new Set([timings.truth, ...timings.rows].map((one) => one.threads).filter(Boolean))];
  const items = [
    ['scene', `${study.scene}${study.define.map(([key, value]) => ` ${key}=${value}`).join('')}`], ['scene hash', study.scene_hash],
    ['sensor', `${study.sensor} (${study.plugin})`], ['version', `nephroid ${report.version}`], ['program hash', timings.program],
    ['machine', `${timings.machine}, ${timings.processors} processors; ${threads.join(', ') || '–'} threads`],
    ['seed', `${study.seed}; the truth’s is its own`], ['margin', percent(study.margin)], ['truth’s film', truth.file],
  ];
  place('environment').append(...items.flatMap(([term, text]) => [element('dt', {}, term), element('dd', {}, String(text))]));
  const copy = (text) => element('button', { type: 'button', onclick: (event) => { navigator.clipboard?.writeText(text); event.target.textContent = 'copied'; } }, 'copy');
  const lines = [[`truth, ${truthLabel}`, truth.command], ...rows.flatMap((row) => [[row.label, row.command], [row.command ? '' : row.label, row.compare]])].filter(([, command]) => command);
  place('commands').append(element('tbody', {}, ...lines.map(([name, command]) => element('tr', {},
    element('td', { class: 'text' }, name), element('td', { class: 'text wrap' }, element('code', {}, command)), element('td', {}, copy(command))))));
  place('requirements').append(...report.requirements.map((one) => element('li', { class: one.needed ? null : 'muted' }, `${one.feature}: ${one.needed ? 'yes' : 'no'}, ${one.reason}`)));
  place('conventions').append(...report.conventions.map((text) => element('li', {}, text)));
}

async function choose(i) {
  chosen = i;
  for (const line of document.querySelectorAll('#rows tbody tr')) line.setAttribute('aria-selected', Number(line.dataset.row) === i);
  for (const name of document.querySelectorAll('.chosen')) name.textContent = rows[i].label;
  document.querySelector('[data-control=run]').value = i;
  figures(rows[i]);
  ledger(rows[i]);
  cost();
  await viewer.show(rows[i]);
  document.body.dataset.shown = i;
}

notices();
lead();
summary();
stageErrors();
controls();
record();
// The run that a reader asks for first: the nearest to the truth that is resolved, else the last.
const first = rows.map((row, i) => [row, i]).filter(([row]) => row.resolved).sort(([a], [b]) => a.error - b.error)[0]?.[1] ?? rows.length - 1;
if (rows.length) choose(first);
