// The page: what is said of the whole study, and a part for each sensor.

const data = JSON.parse(document.getElementById('data').textContent);
const { report, timings } = data;
const place = (id) => document.getElementById(id);
const judged = (row) => row.comparison.layers.find((layer) => layer.layer === row.layer);
// The machines of all runs, each once.
const machines = [...new Set(timings.sensors.flatMap((sensor) => [sensor.truth, ...sensor.rows]).map((one) => one.machine)
  .filter(Boolean).map((one) => JSON.stringify(one)))].map((one) => JSON.parse(one));
const counter = (row, name) => row.facts?.counters.find((one) => one.name === name)?.count ?? null;

// The curve of light in a coffee cup, which the program is named after: as in every cup, from its own formula.
place('nephroid').setAttribute('d', Array.from({ length: 121 }, (_, i) => {
  const t = (Math.PI * i) / 60;
  return `${i ? 'L' : 'M'}${((3 * Math.sin(t) - Math.sin(3 * t)) / 2).toFixed(3)} ${((3 * Math.cos(t) - Math.cos(3 * t)) / 2).toFixed(3)}`;
}).join(''));

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

function time({ median, seconds }) {
  if (median === null) return '–';
  const spread = seconds.length > 1 ? element('span', { class: 'muted' }, ` (${number(Math.min(...seconds), 3)}–${number(Math.max(...seconds), 3)})`) : null;
  return element('span', {}, number(median, 3), spread);
}

/** The title, and the way to the parts of the only sensor, or to each of several. */
function heading(parts) {
  const name = report.study.scene.replace(/^.*[\\/]/, '').replace(/\.xml$/, '');
  const sensors = report.sensors.map((one) => one.sensor);
  const isOnly = parts.length === 1;
  place('title').textContent = isOnly ? `${name}, ${sensors[0]}` : name;
  place('subtitle').textContent = isOnly ? parts[0].subtitle : `${sensors.length} sensors: ${sensors.join(', ')}`;
  const links = isOnly
    ? [['summary', 'Summary'], ['where', 'Where'], ['scales', 'Scale'], ['cost', 'Cost'], ...(report.sensors[0].stages.length ? [['stages', 'Stages']] : []), ['figures', 'Figures'], ['flux', 'Flux']]
    : parts.map((part) => [part.part('heading').id, part.figures.sensor]);
  place('links').append(...[...links, ['record', 'Record']].map(([id, text]) => element('a', { href: `#${id}` }, text)));
}

function notices() {
  const list = [...report.warnings];
  for (const [i, { sensor, truth, rows, gates }] of report.sensors.entries()) {
    const on = report.sensors.length > 1 ? `${sensor}: ` : '';
    list.push(...timings.sensors[i].notes.map((note) => `${on}${note}.`));
    for (const gate of gates) {
      if (gate.verdict !== 'kept') {
        const { figure, most, unit } = gate.limit;
        const show = (value) => ({ fraction: percent, texels: (it) => `${number(it, 3)} texels`, metres: length }[unit](value));
        list.push(`${on}Limit of ${show(most)} on ${figure} of ${gate.name}: ${gate.verdict}; it is ${gate.error ? show(gate.error.value) : 'not defined'}.`);
      }
    }
    for (const row of rows) {
      for (const check of row.checks) list.push(`${on}${row.label}: ${check.message}.`);
      for (const warning of row.facts?.warnings ?? []) if (!list.includes(warning)) list.push(warning);
    }
    if (!truth.facts.complete) list.push(`${on}The truth did not reach the error asked for.`);
  }
  if (list.length) {
    place('notices').hidden = false;
    place('notices').append(element('ul', {}, ...list.map((text) => element('li', {}, text))));
  }
}

function record() {
  const { study } = report;
  const all = timings.sensors.flatMap((sensor) => [sensor.truth, ...sensor.rows]);
  const places = [...new Set(all.filter((one) => one.machine).map(({ machine, threads }) => `${machine.host}, ${machine.processor} (${threads} threads)`))];
  const items = [
    ['scene', `${study.scene}${study.define.map(([key, value]) => ` ${key}=${value}`).join('')}`], ['scene hash', study.scene_hash],
    ['sensors', report.sensors.map((one) => `${one.sensor} (${one.plugin})`).join(', ')],
    ['version', `nephroid ${report.version}`], ['commit', timings.commit], ['source hash', timings.program],
    [machines.length > 1 ? 'machines' : 'machine', places.join('; ') || '–'],
    ['seed', `${study.seed}; the truth’s is its own`], ['margin', percent(study.margin)],
    ['truth’s film', report.sensors.map((one) => one.truth.file).join(', ')],
  ];
  place('environment').append(...items.flatMap(([term, text]) => [element('dt', {}, term), element('dd', {}, String(text))]));
  const copy = (text) => element('button', { type: 'button', onclick: (event) => { navigator.clipboard?.writeText(text); event.target.textContent = 'copied'; } }, 'copy');
  const lines = report.sensors.flatMap(({ sensor, truth, rows }) => {
    const on = report.sensors.length > 1 ? `${sensor}: ` : '';
    return [[`${on}truth, ${truth.label}`, truth.command],
      ...rows.flatMap((row) => [[on + row.label, row.command], [row.command ? '' : on + row.label, row.compare]])];
  }).filter(([, command]) => command);
  place('commands').append(element('tbody', {}, ...lines.map(([name, command]) => element('tr', {},
    element('td', { class: 'text' }, name), element('td', { class: 'text wrap' }, element('code', {}, command)), element('td', {}, copy(command))))));
  place('requirements').append(...report.requirements.map((one) => element('li', { class: one.needed ? null : 'muted' }, `${one.feature}: ${one.needed ? 'yes' : 'no'}, ${one.reason}`)));
  place('conventions').append(...report.conventions.map((text) => element('li', {}, text)));
}

notices();
const parts = report.sensors.map((_, i) => new SensorPart(i));
heading(parts);
record();
const kept = location.hash.match(/^#view=(.*)$/);
if (kept) {
  try {
    const view = JSON.parse(decodeURIComponent(kept[1]));
    parts[view.sensor]?.restore(view);
  } catch (error) {
    if (!(error instanceof SyntaxError || error instanceof URIError)) throw error;
    place('notices').hidden = false;
    place('notices').append(element('p', {}, 'The address names no view that can be read.'));
  }
}
