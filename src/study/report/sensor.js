// One sensor's part of the page: its summary, viewer, plots and tables, all of which follow one chosen run.

/** The figures of light of the layer that a row is judged by. */
const light = (row) => judged(row)?.fidelity;

/** A figure between what the truth's bars allow. */
function between(value, ends, show) {
  return element('span', { title: ends.low === null ? null : `between ${show(ends.low)} and ${ends.high === null ? 'anything' : show(ends.high)}` }, value);
}

function displacement(found) {
  if (!found) return '–';
  const metres = found.metres ? ` (${length(found.metres.value)})` : '';
  return between(`${number(found.texels.value, 3)}${metres}`, found.texels, (value) => `${number(value, 3)} texels`);
}

function resolution(figures) {
  if (!figures?.energy) return '–';
  if (!figures.resolution) return element('span', { class: 'muted', title: 'L2 is above 10 % at all scales' }, 'none');
  const { texels, metres } = figures.resolution;
  return `${number(texels.value, 3)}${metres ? ` (${length(metres)})` : ''}`;
}

class SensorPart {
  /** Builds the part of a sensor, by its place in the report. */
  constructor(index) {
    this.index = index;
    this.figures = report.sensors[index];
    this.timings = timings.sensors[index];
    this.total = this.figures.quantity === 'radiance' ? 'L' : 'E';
    this.chosen = 0;
    this.figure = 'l1';
    this.figureChoices = [];
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
    this.chooseFigure(this.figure);
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
    const kept = gates.filter((gate) => gate.verdict === 'kept').map((gate) => `${gate.name} keeps its limit on ${gate.limit.figure}.`);
    this.part('lead').textContent = [
      `The truth, ${truth.label}, ${own}${median ? `, and took ${number(median, 3)} s` : ''}.`,
      resolved === rows.length ? '' : `It resolves ${resolved} of ${rows.length} runs.`, ...kept,
    ].filter(Boolean).join(' ');
    this.part('answers').append(...answers.flatMap(({ name, sentences }) => [
      element('dt', {}, element('span', { class: 'dot', style: `background: ${this.colourOf(name)}` }), name),
      element('dd', {}, sentences.join(' ')),
    ]));
  }

  /** A choice of the figure. The choices of all sections are one. */
  figureChoice() {
    const select = element('select', { 'data-control': 'figure', onchange: () => this.chooseFigure(select.value) },
      ...Object.entries(FIGURES).map(([key, { name }]) => element('option', { value: key }, name)));
    this.figureChoices.push(select);
    return element('label', {}, 'Figure', select);
  }

  /** Shows one figure in all sections. */
  chooseFigure(figure) {
    this.figure = figure;
    for (const select of this.figureChoices) select.value = figure;
    for (const show of this.stageErrors) show(figure);
    this.gauges();
    this.cost();
  }

  summary() {
    const { rows } = this.figures;
    const times = this.timings.rows;
    const figure = (title, value, show) => ({ title, value: (row) => value(row) ?? null, show: (row) => show(value(row)) });
    const columns = [
      { title: 'run', text: true, value: (row) => row.label, show: (row) => element('span', {}, element('span', { class: 'dot', style: `background: ${this.colourOf(row.name)}` }), row.label) },
      figure('energy', (row) => light(row)?.energy?.value, (value) => percent(value)),
      { title: 'L1', value: (row) => row.error, show: (row) => element('span', { class: row.resolved ? null : 'muted' }, percent(row.error)) },
      { title: '', show: (_, i) => element('span', { 'data-gauge': i }) },
      figure('misplaced', (row) => light(row)?.misplaced?.value, (value) => percent(value)),
      { title: 'displaced', unit: 'texels', value: (row) => light(row)?.displaced?.texels.value ?? null, show: (row) => displacement(light(row)?.displaced) },
      { title: 'right at', unit: 'texels', value: (row) => light(row)?.resolution?.texels.value ?? null, show: (row) => resolution(light(row)) },
      figure('FLIP', (row) => row.picture?.flip, (value) => number(value, 3)),
      figure('rays', (row) => counter(row, 'rays'), (value) => number(value, 3)),
      { title: 'time', unit: 's', value: (_, i) => times[i].median, show: (_, i) => time(times[i]) },
      { title: 'front', value: (row) => (row.pareto.rays ? 0 : 1), show: (row) => (row.pareto.rays ? '●' : '') },
      { title: '', text: true, show: (row, i) => element('span', {}, ...this.remarks(row, times[i])) },
    ];
    this.part('rows').closest('.scroll').after(tableButtons(this.part('rows')));
    this.part('summary-controls').append(this.figureChoice());
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

  /** Bars for the figure of all rows, each of the light that it is judged by. */
  gauges() {
    const errors = this.figures.rows.map((row) => this.errorIn(row, row.layer));
    const known = errors.flatMap(({ error, bar }) => [error, bar]).filter((value) => value > 0);
    const range = [Math.min(...known) / 1.5, Math.max(...known) * 1.1];
    for (const host of this.part('rows').querySelectorAll('[data-gauge]')) {
      host.replaceChildren(this.gauge(this.figures.rows[host.dataset.gauge], errors[host.dataset.gauge], range));
    }
  }

  /** A bar for an error on a logarithmic scale over all rows, with a tick where the truth's own error is. */
  gauge(row, { error, bar }, [low, high]) {
    const along = (value) => 100 * Math.min(1, Math.max(0.01, Math.log(value / low) / Math.log(high / low)));
    if (!(error > 0)) return '';
    const { name, show } = FIGURES[this.figure];
    return drawn('svg', { class: 'gauge', viewBox: '0 0 100 10', preserveAspectRatio: 'none', role: 'img', 'aria-label': `${name} ${show(error).replace('+', '')}`, style: `color: ${this.colourOf(row.name)}` },
      drawn('rect', { width: 100, height: 10 }), drawn('rect', { class: 'bar', width: along(error), height: 10 }),
      bar > 0 ? drawn('line', { x1: along(bar), x2: along(bar), y1: 0, y2: 10, 'vector-effect': 'non-scaling-stroke' }) : null);
  }

  remarks(row, { machine }) {
    const said = row.checks.map((check) => element('span', { class: 'alarm', title: check.message }, `${check.kind}? `));
    if (!row.resolved) said.push(element('span', { class: 'muted', title: `the truth's own error is ${percent(row.truth_error)}` }, 'not resolved '));
    if (row.same.length) said.push(element('span', { class: 'muted' }, `the same film: ${row.same.join(', ')} `));
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
    this.against = element('select', { 'data-control': 'against', onchange: () => this.choose(this.chosen) },
      element('option', { value: '' }, 'the truth'), ...rows.map((row, i) => element('option', { value: i }, row.label)));
    const layer = element('select', { 'data-control': 'layer', onchange: (event) => { viewer.layer = event.target.value; this.choose(this.chosen); } },
      element('option', { value: '' }, 'as judged'), ...viewer.layers().map((name) => element('option', { value: name }, name)));
    const flip = element('button', { type: 'button', 'data-control': 'flip', 'aria-pressed': 'false', onclick: () => viewer.set({ flipped: !state.flipped }) }, 'Flip');
    const slider = element('input', { type: 'range', min: -8, max: 12, step: 0.5, value: 0, 'data-control': 'exposure', oninput: (event) => viewer.set({ exposure: Number(event.target.value) }) });
    const stops = element('output', {}, '0 stops');
    const wipe = element('button', { type: 'button', 'data-control': 'wipe', 'aria-pressed': 'false', onclick: () => viewer.set({ wipe: !state.wipe }) }, 'Wipe');
    const select = element('select', { 'data-control': 'run', onchange: (event) => this.choose(Number(event.target.value)) },
      ...rows.map((row, i) => element('option', { value: i }, row.label)));
    const scales = [['light', 'false colour'], ['grey', 'grey'], ...(viewer.hasColour ? [['rgb', 'as they are (sRGB)']] : [])];
    this.part('where').querySelector('.controls').append(
      element('label', {}, 'Run', select), element('label', {}, 'Against', this.against), element('label', {}, 'Light', layer), choice('Map', 'map', Object.entries(MAPS).map(([key, map]) => [key, map.name])),
      choice('Colours', 'colours', scales), choice('Scale', 'scale', [['log', 'logarithmic'], ['linear', 'linear']]),
      element('label', {}, 'Exposure', slider, stops), wipe, flip, element('button', { type: 'button', 'data-control': 'fit', onclick: () => viewer.fit() }, 'Fit'),
      element('button', { type: 'button', 'data-control': 'inset', onclick: async () => offer(`${this.figures.rows[this.chosen].name}-inset.png`, await viewer.inset()) }, 'Save inset'),
      element('button', { type: 'button', 'data-control': 'link', onclick: (event) => { location.hash = this.link(); navigator.clipboard?.writeText(location.href); event.target.textContent = 'Link copied'; } }, 'Link to this view'),
    );
    const follow = () => {
      wipe.setAttribute('aria-pressed', state.wipe);
      flip.setAttribute('aria-pressed', state.flipped);
      slider.value = state.exposure;
      stops.textContent = `${state.exposure > 0 ? '+' : ''}${number(state.exposure, 2)} stops`;
    };
    const panes = this.part('panes');
    panes.addEventListener('viewer', follow);
    panes.addEventListener('turn', (event) => this.choose((this.chosen + event.detail + rows.length) % rows.length));
    panes.addEventListener('place', (event) => this.profile(event.detail));
    panes.addEventListener('region', () => this.region());
    const isRow = this.part('profile-direction');
    isRow.addEventListener('change', () => this.profile());
    const { step } = data.pictures[this.index];
    const reduced = step > 1 ? `Pictures are means of ${step} × ${step} texels; the films beside this page have all. ` : '';
    this.part('precision').textContent = `${reduced}Numbers are means of channels; bars are one standard error, or half the distance of bounds. Read-outs have 4 digits; the films have all.`;
  }

  /** L2 against scale, of all rows that are judged by the same light as the one that is chosen. */
  scales(row) {
    const runs = this.figures.rows.map((one, i) => ({ row: i, label: one.label, colour: this.colourOf(one.name), scales: light(one)?.scales ?? [], chosen: i === this.chosen }))
      .filter((_, i) => this.figures.rows[i].layer === row.layer);
    const { spacing } = data.pictures[this.index];
    const metre = spacing && spacing[0] === spacing[1] ? spacing[0] : null;
    scalePlot(this.part('scale-plot'), { runs, metre, choose: (i) => this.choose(i) });
  }

  /** The films that stand beside the chosen run: the truth first, then all rows that are judged by the same light. */
  async films() {
    const row = this.figures.rows[this.chosen];
    const truth = this.viewer.truthOf(row);
    const rows = this.figures.rows.map((one, i) => ({ one, i }))
      .filter(({ one }) => (this.viewer.layer ? this.viewer.hasLight(one, row) : one.layer === row.layer));
    return Promise.all([
      { label: 'truth', file: truth, colour: 'var(--ink)', chosen: false },
      ...rows.map(({ one, i }) => ({ label: one.label, file: this.viewer.fileOf(one), colour: this.colourOf(one.name), chosen: i === this.chosen })),
    ].map(async (film) => ({ ...film, values: await this.viewer.numbers(film.file, 'value'), bar: await this.viewer.numbers(film.file, 'bar') })));
  }

  /** The profile through a place, or through the brightest texel of the truth. */
  async profile(place = this.profilePlace) {
    const { viewer } = this;
    const films = await this.films();
    if (!place) {
      const truth = films[0].values;
      let brightest = 0;
      for (let i = 1; i < truth.length; i++) if (truth[i] > truth[brightest]) brightest = i;
      place = { x: brightest % viewer.width, y: Math.floor(brightest / viewer.width) };
    }
    const isRow = this.part('profile-direction').value === 'row';
    const at = Math.floor(isRow ? place.y : place.x);
    if (at < 0 || at >= (isRow ? viewer.height : viewer.width)) return;
    this.profilePlace = place;
    viewer.line = { isRow, at };
    const { step, spacing } = data.pictures[this.index];
    profilePlot(this.part('profile'), { films, line: viewer.line, size: [viewer.width, viewer.height], unit: this.figures.unit, step, metre: spacing?.[isRow ? 0 : 1] });
    viewer.draw();
  }

  /** Figures of the region that was dragged. */
  async region() {
    const { region, width } = this.viewer;
    const host = this.part('region');
    if (!region) return;
    const table = element('table');
    const { step } = data.pictures[this.index];
    const [columns, lines, x, y] = [region.width, region.height, region.x, region.y].map((count) => count * step);
    const column = (title, key, show) => ({ title, value: (it) => it[key], show: (it) => show(it[key]) });
    sortable(table, [
      { title: `${columns} × ${lines} texels at (${x}, ${y})`, text: true, value: (it) => it.label, show: (it) => it.label },
      { ...column('mean', 'mean', (it) => number(it)), unit: this.figures.unit }, column('energy', 'energy', (it) => percent(it)), column('L1', 'l1', (it) => percent(it)),
    ], regionFigures(await this.films(), region, width));
    host.replaceChildren(element('div', { class: 'scroll' }, table), tableButtons(table));
    this.viewer.draw();
  }

  /** The view as a part of an address. */
  link() {
    const { state, view, region } = this.viewer;
    return `view=${encodeURIComponent(JSON.stringify({ sensor: this.index, run: this.chosen, against: this.against.value, layer: this.viewer.layer, figure: this.figure, state, view, region }))}`;
  }

  /** Goes to the view that an address names. */
  async restore({ run, against, layer, figure, state, view, region }) {
    this.against.value = against ?? '';
    this.viewer.layer = layer ?? '';
    this.article.querySelector('[data-control=layer]').value = this.viewer.layer;
    if (figure in FIGURES) this.chooseFigure(figure);
    Object.assign(this.viewer.state, state);
    if (view) this.viewer.view = view;
    this.viewer.region = region;
    await this.choose(Math.min(run ?? 0, this.figures.rows.length - 1));
    for (const [key, control] of [['map', 'map'], ['colours', 'colours'], ['scale', 'scale']]) {
      this.article.querySelector(`[data-control=${control}]`).value = this.viewer.state[key];
    }
    this.viewer.set({});
    if (region) await this.region();
    this.part('where').scrollIntoView();
  }

  /** The error of a row in one kind of light: a row that is judged by one layer has no other that could be judged. */
  errorIn(row, layer) {
    const found = row.layer === layer || row.layer === this.total ? row.comparison.layers.find((one) => one.layer === layer) : null;
    if (!found) return { error: null };
    // The truth's likely error in the terms of L1, as in study/truth.rs; direct light has no part in a layer of its own.
    const sigma = this.figures.truth.facts.spread.specular;
    const likely = row.layer === layer ? row.truth_error : sigma === null ? null : sigma / found.difference.mean_reference;
    const l1 = found.fidelity.l1?.value ?? null;
    const resolved = row.layer === layer ? row.resolved : likely !== null && likely <= 0.1 * l1;
    if (this.figure === 'l1') return { error: l1, bar: likely ?? 0, resolved };
    const value = {
      l2: (it) => it.fidelity.l2, misplaced: (it) => it.fidelity.misplaced, displaced: (it) => it.fidelity.displaced?.texels,
      energy: (it) => it.fidelity.energy && { value: Math.abs(it.fidelity.energy.value - 1) },
    }[this.figure](found);
    return { error: value?.value ?? null, bar: 0, resolved };
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
    this.part('cost').querySelector('.controls').append(this.figureChoice(), element('label', {}, 'Cost', this.axis), ...(layers.length > 1 ? [element('label', {}, 'Light', this.light)] : []));
  }

  cost() {
    const { rows, curves } = this.figures;
    const [axis, layer] = [this.axis.value, this.light.value];
    const isLength = this.figure === 'displaced';
    // The size of what is missing or too much.
    const name = this.figure === 'energy' ? '|energy − 1|' : FIGURES[this.figure].name;
    const shown = (value) => FIGURES[this.figure].show(value).replace('+', '');
    const of = (i) => (axis === 'seconds' ? this.timings.rows[i].median : counter(rows[i], axis));
    const own = (curve) => rows[curve.rows[0]].facts?.counters.at(-1)?.name;
    const points = (curve) => curve.rows.map((i) => {
      const found = this.errorIn(rows[i], layer);
      return { ...found, cost: of(i), row: i, label: `${rows[i].label}\n${name} ${shown(found.error)}${found.bar ? ` ± ${shown(found.bar)}` : ''} in ${layer}\n${axis} ${number(of(i), 4)}` };
    }).filter(({ cost, error }) => cost > 0 && error > 0).sort((a, b) => a.cost - b.cost);
    const lines = curves.map((curve, i) => {
      const marks = points(curve);
      const isOwn = this.figure === 'l1' && curve.rows.every((row) => rows[row].layer === layer);
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
    const levels = rows.map((row, i) => ({ row: i, name: row.label, error: this.errorIn(row, layer).error, cost: of(i), colour: this.colourOf(row.name) }))
      .filter((level) => !(of(level.row) > 0) && level.error > 0);
    this.part('cost').querySelector('.exports')?.remove();
    this.part('plot').after(exportButtons(this.part('plot'), `cost-${axis}`));
    costPlot(this.part('plot'), { curves: lines, levels, axis, light: layer, figure: name, isLength, shown, front, chosen: this.chosen, choose: (i) => this.choose(i) });
  }

  stages() {
    const { stages } = this.figures;
    this.part('stages').hidden = !stages.length;
    this.stageErrors = [];
    for (const one of stages) {
      const { nodes, show } = stageErrors(one, this.colourOf(one.name), this.figureChoice());
      this.part('waterfalls').append(...nodes);
      this.stageErrors.push(show);
    }
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
      figure('L1', (it) => it.fidelity.l1?.value, percent),
      figure('L2', (it) => it.fidelity.l2?.value, percent),
      figure('misplaced', (it) => it.fidelity.misplaced?.value, percent),
      figure('displaced', (it) => it.fidelity.displaced?.texels.value, (it) => number(it, 3), 'texels'),
      figure('rel. RMSE', (it) => it.difference.relative_rmse, percent),
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
      ['half in', `half of the squared error is in ${percent(row.half_in, 2)} of the texels`],
      ['films', element('span', {}, element('a', { href: this.figures.truth.file }, 'truth.exr'), ' ', element('a', { href: row.file }, 'run.exr'))],
      ['picture', `FLIP ${number(row.picture?.flip, 3)}, SSIM ${number(row.picture?.ssim, 4)}, with all light`],
      ['own error', row.facts ? percent(row.facts.own_error) : 'not told'],
      ['truth’s error', percent(row.truth_error)],
    ] : [];
    if (row.comparison.notes.length) items.push(['notes', row.comparison.notes.join('; ')]);
    this.part('verdict').replaceChildren(...items.flatMap(([term, text]) => [element('dt', {}, term), element('dd', {}, text)]));
  }

  ledger(row) {
    const table = row.facts?.ledger;
    const stages = row.facts?.stage_flux ?? [];
    const plot = this.part('stage-flux');
    plot.hidden = !stages.length;
    if (stages.length) {
      stageFlux(plot, stages, light(row)?.energy?.value);
      this.part('flux-lead').textContent = 'Of the light that sets out towards mirrors and glass in the light’s view: what each stage drops or adds, down to the image.';
      this.part('ledger').replaceChildren();
      return;
    }
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
    this.scales(row);
    this.ledger(row);
    this.cost();
    // A run is held against another with the same light only.
    for (const option of this.against.options) {
      option.disabled = option.value !== '' && !this.viewer.hasLight(this.figures.rows[Number(option.value)], row);
    }
    if (this.against.selectedOptions[0]?.disabled) this.against.value = '';
    const against = this.against.value ? this.figures.rows[Number(this.against.value)] : null;
    await this.viewer.show(row, against);
    await this.profile();
    if (this.viewer.region) await this.region();
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
