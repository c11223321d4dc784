// One sensor's part of the page: its summary, viewer, plots and tables, all of which follow one chosen run.

class SensorPart {
  /** Builds the part of a sensor, by its place in the report. */
  constructor(index) {
    this.index = index;
    this.figures = report.sensors[index];
    this.timings = timings.sensors[index];
    this.total = this.figures.quantity === 'radiance' ? 'L' : 'E';
    this.chosen = 0;
    this.article = document.getElementById('sensor').content.firstElementChild.cloneNode(true);
    // Names of parts are ids: those of the first sensor as they are, so that links to #where lead somewhere.
    for (const node of this.article.querySelectorAll('[data-part]')) {
      const { part } = node.dataset;
      node.id = index ? `${part}-${index}` : part;
      const title = node.querySelector(':scope > h2');
      if (!title) continue;
      title.id = `${node.id}-title`;
      node.setAttribute('aria-labelledby', title.id);
    }
    document.getElementById('sensors').append(this.article);
    this.heading();
    this.lead();
    this.summary();
    this.stages();
    this.viewer = new Viewer({ ...data.pictures[index], unit: this.figures.unit, truth: this.figures.truth.file, name: `sensor-${index}` }, this.part('panes'), this.part('readout'));
    this.controls();
    this.costControls();
    const { rows } = this.figures;
    if (rows.length) this.choose(this.firstRow());
  }

  part(name) {
    return this.article.querySelector(`[data-part=${name}]`);
  }

  colourOf(name) {
    return `var(--c${this.figures.curves.findIndex((curve) => curve.name === name) % 6})`;
  }

  /** The run that a reader asks for first: a film from elsewhere, an approximation, else the nearest to the truth that is resolved. */
  firstRow() {
    const { rows } = this.figures;
    const places = rows.map((row, i) => i).sort((a, b) => rows[a].error - rows[b].error);
    return places.find((i) => !rows[i].method) ?? places.find((i) => rows[i].layer !== this.total)
      ?? places.find((i) => rows[i].resolved) ?? rows.length - 1;
  }

  heading() {
    const { sensor, quantity, unit, size, truth } = this.figures;
    this.subtitle = `${quantity} [${unit}] on ${size.join(' × ')} ${quantity === 'radiance' ? 'pixels' : 'texels'}; truth by ${truth.label}`;
    const heading = this.part('heading');
    heading.hidden = report.sensors.length === 1;
    heading.querySelector('h2').textContent = sensor;
    heading.querySelector('p').textContent = this.subtitle;
  }

  lead() {
    const { truth, rows, gates, answers } = this.figures;
    const { median } = this.timings.truth;
    const own = truth.facts.own_error === null ? 'does not know its own error' : `is known to ${percent(truth.facts.own_error, 2)} (its own figure)`;
    const resolved = rows.filter((row) => row.resolved).length;
    const kept = gates.filter((gate) => gate.verdict === 'kept').map((gate) => `${gate.name} keeps its limit of ${percent(gate.limit)}.`);
    this.part('lead').textContent = [
      `The truth, ${truth.label}, ${own}${median ? `, and took ${number(median, 3)} s` : ''}.`,
      resolved === rows.length ? '' : `It resolves ${resolved} of ${rows.length} runs.`, ...kept,
    ].filter(Boolean).join(' ');
    this.part('answers').append(...answers.flatMap(({ name, sentences }) => [
      element('dt', {}, element('span', { class: 'dot', style: `background: ${this.colourOf(name)}` }), name),
      element('dd', {}, sentences.join(' ')),
    ]));
  }

  summary() {
    const { rows } = this.figures;
    const times = this.timings.rows;
    const errors = rows.flatMap((row) => [row.error, row.truth_error]).filter((value) => value > 0);
    const range = [Math.min(...errors) / 1.5, Math.max(...errors) * 1.1];
    const figure = (title, value, show) => ({ title, value: (row) => value(row) ?? null, show: (row) => show(value(row)) });
    const columns = [
      { title: 'run', text: true, value: (row) => row.label, show: (row) => element('span', {}, element('span', { class: 'dot', style: `background: ${this.colourOf(row.name)}` }), row.label) },
      { title: 'error', value: (row) => row.error, show: (row) => element('span', { class: row.resolved ? null : 'muted' }, percent(row.error)) },
      { title: '', show: (row) => this.gauge(row, range) },
      figure('bias', (row) => row.bias, (value) => signedPercent(value, 2)),
      figure('half in', (row) => row.half_in, (value) => percent(value, 2)),
      figure('SSIM', (row) => judged(row)?.similarity?.ssim, (value) => number(value, 4)),
      figure('FLIP', (row) => judged(row)?.flip?.mean, (value) => number(value, 3)),
      figure('rays', (row) => counter(row, 'rays'), (value) => number(value, 3)),
      { title: 'time', unit: 's', value: (_, i) => times[i].median, show: (_, i) => time(times[i]) },
      { title: 'front', value: (row) => (row.pareto.rays ? 0 : 1), show: (row) => (row.pareto.rays ? '●' : '') },
      { title: '', text: true, show: (row, i) => element('span', {}, ...this.remarks(row, times[i])) },
    ];
    sortable(this.part('rows'), columns, rows, {
      onrow: (line, _, i) => filled(line, {
        tabindex: 0, 'data-row': i, 'aria-selected': 'false', onclick: () => this.choose(i),
        onkeydown: (event) => {
          if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); this.choose(i); }
          if (event.key === 'ArrowDown') { event.preventDefault(); line.nextElementSibling?.focus(); }
          if (event.key === 'ArrowUp') { event.preventDefault(); line.previousElementSibling?.focus(); }
        },
      }, []),
    });
  }

  /** A bar for an error on a logarithmic scale over all rows, with a tick where the truth's own error is. */
  gauge(row, [low, high]) {
    const along = (value) => 100 * Math.min(1, Math.max(0.01, Math.log(value / low) / Math.log(high / low)));
    if (!(row.error > 0)) return '';
    return drawn('svg', { class: 'gauge', viewBox: '0 0 100 10', preserveAspectRatio: 'none', 'aria-hidden': 'true', style: `color: ${this.colourOf(row.name)}` },
      drawn('rect', { width: 100, height: 10 }), drawn('rect', { class: 'bar', width: along(row.error), height: 10 }),
      row.truth_error > 0 ? drawn('line', { x1: along(row.truth_error), x2: along(row.truth_error), y1: 0, y2: 10, 'vector-effect': 'non-scaling-stroke' }) : null);
  }

  remarks(row, { machine }) {
    const said = row.checks.map((check) => element('span', { class: 'alarm', title: check.message }, `${check.kind}? `));
    if (!row.resolved) said.push(element('span', { class: 'muted', title: `the truth's own error is ${percent(row.truth_error)}` }, 'not resolved '));
    if (row.facts && !row.facts.complete) said.push(element('span', { class: 'alarm' }, 'incomplete '));
    if (row.layer !== this.total) said.push(element('span', { class: 'muted' }, `${row.layer} only `));
    if (machine && machines.length > 1) said.push(element('span', { class: 'muted', title: machine.processor }, `on ${machine.host}`));
    return said;
  }

  controls() {
    const { viewer } = this;
    const { state } = viewer;
    const { rows } = this.figures;
    const choice = (name, key, options) => {
      const select = element('select', { 'data-control': key, onchange: (event) => viewer.set({ [key]: event.target.value }) },
        ...options.map(([value, text]) => element('option', { value, selected: state[key] === value }, text)));
      return element('label', {}, name, select);
    };
    const slider = element('input', { type: 'range', min: -8, max: 12, step: 0.5, value: 0, 'data-control': 'exposure', oninput: (event) => viewer.set({ exposure: Number(event.target.value) }) });
    const stops = element('output', {}, '0 stops');
    const wipe = element('button', { type: 'button', 'data-control': 'wipe', 'aria-pressed': 'false', onclick: () => viewer.set({ wipe: !state.wipe }) }, 'Wipe');
    const select = element('select', { 'data-control': 'run', onchange: (event) => this.choose(Number(event.target.value)) },
      ...rows.map((row, i) => element('option', { value: i }, row.label)));
    const scales = [['light', 'false colour'], ['grey', 'grey'], ...(viewer.hasColour ? [['rgb', 'as they are (sRGB)']] : [])];
    this.part('where').querySelector('.controls').append(
      element('label', {}, 'Run', select), choice('Map', 'map', Object.entries(MAPS).map(([key, map]) => [key, map.name])),
      choice('Colours', 'colours', scales), choice('Scale', 'scale', [['log', 'logarithmic'], ['linear', 'linear']]),
      element('label', {}, 'Exposure', slider, stops), wipe, element('button', { type: 'button', 'data-control': 'fit', onclick: () => viewer.fit() }, 'Fit'),
    );
    const follow = () => {
      wipe.setAttribute('aria-pressed', state.wipe);
      slider.value = state.exposure;
      stops.textContent = `${state.exposure > 0 ? '+' : ''}${number(state.exposure, 2)} stops`;
    };
    const panes = this.part('panes');
    panes.addEventListener('viewer', follow);
    panes.addEventListener('turn', (event) => this.choose((this.chosen + event.detail + rows.length) % rows.length));
    const { step } = data.pictures[this.index];
    const reduced = step > 1 ? `Pictures are means of ${step} × ${step} texels; the films beside this page have all. ` : '';
    this.part('precision').textContent = `${reduced}Numbers are means of channels; bars are one standard error, or half the distance of bounds. Read-outs have 4 digits; the films have all.`;
  }

  /** The error of a row in one kind of light: a row that is judged by one layer has no other that could be judged. */
  errorIn(row, layer) {
    if (row.layer === layer) return { error: row.error, bar: row.truth_error ?? 0, resolved: row.resolved };
    const found = row.layer === this.total && row.comparison.layers.find((one) => one.layer === layer)?.difference;
    if (!found) return { error: null };
    // The truth's error in the terms of a row, as in study/truth.rs; direct light has no part in a layer of its own.
    const sigma = this.figures.truth.facts.spread.specular;
    const [width, height] = this.figures.size;
    const bar = sigma === null || !found.lit ? null : (sigma * Math.sqrt((width * height) / found.lit)) / found.mean_lit;
    return { error: found.relative_rmse, bar: bar ?? 0, resolved: bar !== null && bar <= 0.1 * found.relative_rmse };
  }

  /** The choices of cost and light. Light of which most is known is first, but none that hides a film from elsewhere. */
  costControls() {
    const { rows } = this.figures;
    const names = [...new Set(rows.flatMap((row) => row.facts?.counters.map((one) => one.name) ?? []))];
    this.axis = element('select', { id: this.index ? null : 'cost-axis', onchange: () => this.cost() },
      ...names.map((name) => element('option', { value: name }, name)), element('option', { value: 'seconds' }, 'seconds'));
    const known = (layer) => rows.filter((row) => this.errorIn(row, layer).error > 0);
    const layers = [...new Set(rows.map((row) => row.layer))].sort((a, b) => {
      const [left, right] = [a, b].map((layer) => known(layer).length + rows.length * known(layer).filter((row) => !row.method).length);
      return right - left;
    });
    this.light = element('select', { 'data-control': 'light', onchange: () => this.cost() },
      ...layers.map((layer) => element('option', { value: layer }, layer === this.total ? `${layer}, all light` : layer)));
    this.part('cost').querySelector('.controls').append(element('label', {}, 'Cost', this.axis), ...(layers.length > 1 ? [element('label', {}, 'Light', this.light)] : []));
  }

  cost() {
    const { rows, curves } = this.figures;
    const [axis, layer] = [this.axis.value, this.light.value];
    const of = (i) => (axis === 'seconds' ? this.timings.rows[i].median : counter(rows[i], axis));
    const own = (curve) => rows[curve.rows[0]].facts?.counters.at(-1)?.name;
    const points = (curve) => curve.rows.map((i) => {
      const found = this.errorIn(rows[i], layer);
      return { ...found, cost: of(i), row: i, label: `${rows[i].label}\nerror ${percent(found.error)} ± ${percent(found.bar, 2)} in ${layer}\n${axis} ${number(of(i), 4)}` };
    }).filter(({ cost, error }) => cost > 0 && error > 0).sort((a, b) => a.cost - b.cost);
    const lines = curves.map((curve, i) => {
      const marks = points(curve);
      const isOwn = curve.rows.every((row) => rows[row].layer === layer);
      const known = [...curve.orders, this.timings.orders[i]].filter(Boolean);
      const wanted = axis === 'rays' && isOwn ? ['rays', own(curve)] : [axis];
      const used = new Set(marks.filter((mark) => mark.resolved).map((mark) => JSON.stringify(this.timings.rows[mark.row].machine)));
      if (axis === 'seconds' && used.size > 1) return { name: curve.name, colour: this.colourOf(curve.name), points: marks, orders: [{ note: 'no order: several machines' }] };
      const orders = isOwn ? known.filter((order) => wanted.includes(order.cost)) : [fittedOrder(marks, axis)].filter(Boolean);
      return { name: curve.name, colour: this.colourOf(curve.name), points: marks, orders };
    });
    const all = lines.flatMap((line) => line.points);
    const front = new Set(all.filter((one) => !all.some((other) => other.cost <= one.cost && other.error <= one.error
      && (other.cost < one.cost || other.error < one.error))).map((point) => point.row));
    // What has an error and no such cost, as a film from elsewhere, is a level.
    const levels = rows.map((row, i) => ({ row: i, name: row.label, error: this.errorIn(row, layer).error, colour: this.colourOf(row.name) }))
      .filter((level) => !(of(level.row) > 0) && level.error > 0);
    costPlot(this.part('plot'), { curves: lines, levels, axis, light: layer, front, chosen: this.chosen, choose: (i) => this.choose(i) });
  }

  stages() {
    const { stages } = this.figures;
    this.part('stages').hidden = !stages.length;
    this.part('waterfalls').append(...stages.flatMap((one) => stageErrors(one, this.colourOf(one.name))));
  }

  layers(row) {
    const { unit } = this.figures;
    const { margin } = report.study;
    const figure = (title, value, show = (it) => number(it, 4), inUnit) => ({ title, unit: inUnit, value: (it) => value(it) ?? null, show: (it) => show(value(it)) });
    sortable(this.part('layers'), [
      { title: 'layer', text: true, value: (it) => it.layer, show: (it) => it.layer },
      figure('mean of truth', (it) => it.difference.mean_reference, undefined, unit),
      figure('mean', (it) => it.difference.mean_other, undefined, unit),
      figure('bias', (it) => it.equivalence.bias.relative, (it) => signedPercent(it, 3)),
      figure('error', (it) => it.difference.relative_rmse, percent),
      figure('unexplained', (it) => it.equivalence.texels.unexplained, percent),
      figure('relMSE', (it) => it.difference.rel_mse),
      figure('SMAPE', (it) => it.difference.smape),
      figure('95 %', (it) => it.difference.percentiles.find((one) => one.percent === 95)?.value, undefined, unit),
      figure('SSIM', (it) => it.similarity?.ssim),
      figure('FLIP', (it) => it.flip?.mean),
      { title: `within ${percent(margin)}`, text: true, value: (it) => it.equivalence.verdict, show: (it) => it.equivalence.verdict },
    ], row.comparison.layers);
    const layer = judged(row);
    histogram(this.part('histogram'), layer?.significance);
    const worst = layer?.difference.worst;
    const items = worst ? [
      ['largest difference', `${number(worst.difference)} ${unit} at texel (${worst.x}, ${worst.y})`],
      ['truth there', worst.reference.map((value) => number(value)).join(', ')],
      ['run there', worst.other.map((value) => number(value)).join(', ')],
      ['energy', `${number(layer.difference.energy_ratio, 6)} of the truth’s`],
      ['bias', layer.equivalence.bias.interval ? `between ${layer.equivalence.bias.interval.map((it) => signedPercent(it)).join(' and ')}` : '–'],
      ['verdict', `${layer.equivalence.verdict} within ${percent(margin)} (bias ${layer.equivalence.bias.verdict}, texels ${layer.equivalence.texels.verdict})`],
      ['own error', row.facts ? percent(row.facts.own_error) : 'not told'],
      ['truth’s error', percent(row.truth_error)],
    ] : [];
    if (row.comparison.notes.length) items.push(['notes', row.comparison.notes.join('; ')]);
    this.part('verdict').replaceChildren(...items.flatMap(([term, text]) => [element('dt', {}, term), element('dd', {}, text)]));
  }

  ledger(row) {
    const table = row.facts?.ledger;
    if (!table) {
      this.part('flux-lead').textContent = row.facts ? 'This method keeps no ledger on this sensor.' : 'A film from elsewhere has no ledger.';
      this.part('ledger').replaceChildren();
      return;
    }
    const isByDifference = table.elsewhere !== null;
    this.part('flux-lead').textContent = `Of ${number(table.emitted, 6)} W that were traced${isByDifference
      ? `, ${number(table.elsewhere, 5)} W ended elsewhere, by difference: only what is received was followed.`
      : `; the ledger closes to ${number(table.closure_error, 2)}.`}`;
    const flux = (title, key) => ({ title, unit: 'W', value: (it) => it[key], show: (it) => (it[key] === 0 ? '·' : number(it[key], 5)) });
    const fates = isByDifference ? [] : [flux('direct', 'direct'), flux('escaped', 'escaped'), flux('absorbed', 'absorbed'), flux('cut off', 'cut_off')];
    sortable(this.part('ledger'), [{ title: 'after', text: true, value: (it) => it.after, show: (it) => it.after }, flux('received', 'received'), ...fates], table.rows);
  }

  async choose(i) {
    const row = this.figures.rows[i];
    this.chosen = i;
    for (const line of this.part('rows').querySelectorAll('tbody tr')) line.setAttribute('aria-selected', Number(line.dataset.row) === i);
    for (const name of this.article.querySelectorAll('.chosen')) name.textContent = row.label;
    this.article.querySelector('[data-control=run]').value = i;
    this.layers(row);
    this.ledger(row);
    this.cost();
    await this.viewer.show(row);
    this.article.dataset.shown = i;
  }
}

/** The slope of the least squares line through the logarithms of what is resolved, its interval from three different points on: as in study/curve.rs. */
function fittedOrder(points, cost) {
  const logs = points.filter((point) => point.resolved).map((point) => [Math.log(point.cost), Math.log(point.error)]);
  const mean = (axis) => logs.reduce((sum, log) => sum + log[axis], 0) / logs.length;
  const [x, y] = [mean(0), mean(1)];
  const sum = (term) => logs.reduce((all, [a, b]) => all + term(a - x, b - y), 0);
  const squares = sum((a) => a * a);
  if (logs.length < 2 || !(squares > 1e-18 * logs.length)) return null;
  const exponent = sum((a, b) => a * b) / squares;
  const residual = sum((a, b) => (b - exponent * a) ** 2);
  return { cost, exponent, standard_error: new Set(logs.map(String)).size > 2 ? Math.sqrt(residual / ((logs.length - 2) * squares)) : null };
}
