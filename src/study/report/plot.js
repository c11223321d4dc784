// Plots as SVG: error against cost, both logarithmic, and the histogram of p-values.

const PLOT = { width: 900, height: 440, left: 74, right: 190, top: 26, bottom: 52 };

/** Shows a text at an element for as long as it is pointed at or in focus. */
function hint(node, text) {
  const tip = document.getElementById('tip');
  const show = () => {
    tip.textContent = text;
    tip.hidden = false;
    const at = node.getBoundingClientRect();
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(8, Math.min(at.right + 10, innerWidth - box.width - 8))}px`;
    tip.style.top = `${Math.max(8, at.top - box.height - 6)}px`;
  };
  const hide = () => { tip.hidden = true; };
  node.addEventListener('pointerenter', show);
  node.addEventListener('focus', show);
  node.addEventListener('pointerleave', hide);
  node.addEventListener('blur', hide);
  return node;
}

/** A range with room at its ends, in logarithms. */
function padded(values, least) {
  const low = Math.log10(Math.min(...values));
  const high = Math.log10(Math.max(...values));
  const room = Math.max(0.06 * (high - low), (least - (high - low)) / 2, 0.05);
  return [low - room, high + room];
}

/**
 * Curves of error against cost.
 * curves: [{ name, colour, points: [{ cost, error, bar, resolved, label, row }], orders }], an order being one of the report or a { note }
 * levels: [{ error, cost, name, colour, row }], errors without a cost, or with one of 0
 * light: the layer that the errors are of; figure: their name, a length in texels if isLength; shown: a value as text
 */
function costPlot(host, { curves, levels, axis, light, figure, isLength, shown, front, chosen, choose }) {
  const unit = isLength ? 1 : 100;
  const all = curves.flatMap((curve) => curve.points);
  if (!all.length) {
    host.replaceChildren(element('p', { class: 'muted' }, 'No run has both this cost and an error.'));
    return;
  }
  const { width, height, left, right, top, bottom } = PLOT;
  const [x0, x1] = padded(all.map((point) => point.cost), 0.5);
  const ends = all.flatMap(({ error, bar }) => [error, error + bar, ...(error > bar ? [Math.max(error - bar, error / 3)] : [])]);
  const [y0, y1] = padded([...ends, ...levels.map((level) => level.error)], 0.5);
  const x = (cost) => left + ((Math.log10(cost) - x0) / (x1 - x0)) * (width - left - right);
  const y = (error) => height - bottom - ((Math.log10(error) - y0) / (y1 - y0)) * (height - top - bottom);
  const floor = height - bottom;
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'group', 'aria-label': `error against ${axis}` });
  for (const value of logTicks(10 ** x0, 10 ** x1)) {
    svg.append(drawn('line', { class: 'grid', x1: x(value), x2: x(value), y1: top, y2: floor }),
      drawn('text', { x: x(value), y: floor + 18, 'text-anchor': 'middle' }, tick(value)));
  }
  for (const value of logTicks(unit * 10 ** y0, unit * 10 ** y1)) {
    svg.append(drawn('line', { class: 'grid', x1: left, x2: width - right, y1: y(value / unit), y2: y(value / unit) }),
      drawn('text', { x: left - 8, y: y(value / unit) + 4, 'text-anchor': 'end' }, isLength ? tick(value) : `${tick(value)} %`));
  }
  svg.append(
    drawn('line', { class: 'axis', x1: left, x2: width - right, y1: floor, y2: floor }),
    drawn('line', { class: 'axis', x1: left, x2: left, y1: top, y2: floor }),
    drawn('text', { class: 'title', x: (left + width - right) / 2, y: height - 12, 'text-anchor': 'middle' }, axis),
    drawn('text', { class: 'title', x: left - 58, y: top - 9 }, `${figure}${isLength ? ' [texels]' : ''} in ${light}`),
  );
  const steps = all.filter((point) => front.has(point.row)).sort((a, b) => a.cost - b.cost);
  const path = steps.map((point, i) => (i === 0 ? `M${x(point.cost)} ${y(point.error)}` : `H${x(point.cost)}V${y(point.error)}`));
  svg.append(drawn('path', { class: 'front', d: `${path.join('')}H${width - right}` }));
  const labels = [];
  for (const { error, cost, name, colour, row } of levels) {
    const line = drawn('line', {
      class: 'level', x1: left, x2: width - right, y1: y(error), y2: y(error), stroke: colour, tabindex: 0, role: 'button',
      'aria-label': `${name}, ${figure} ${shown(error)}`, onclick: () => choose(row), onkeydown: (event) => event.key === 'Enter' && choose(row),
    });
    svg.append(hint(line, `${name}\n${figure} ${shown(error)}, ${cost === 0 ? `no ${axis}` : `${axis} not known`}`));
    labels.push({ at: y(error), colour, name, orders: [] });
  }
  for (const { name, colour, points, orders } of curves) {
    if (!points.length) continue;
    const line = points.map((point, i) => `${i ? 'L' : 'M'}${x(point.cost)} ${y(point.error)}`).join('');
    svg.append(drawn('path', { class: 'curve', d: line, stroke: colour }));
    for (const point of points) {
      const [px, py] = [x(point.cost), y(point.error)];
      const lower = Math.min(floor, point.error > point.bar ? y(point.error - point.bar) : floor);
      svg.append(drawn('line', { x1: px, x2: px, y1: y(point.error + point.bar), y2: lower, stroke: colour }));
      if (point.row === chosen) svg.append(drawn('circle', { class: 'chosen-ring', cx: px, cy: py, r: 10 }));
      const mark = drawn('circle', {
        class: 'mark-point', cx: px, cy: py, r: 5, stroke: colour, fill: point.resolved ? colour : 'var(--sheet)',
        tabindex: 0, role: 'button', 'aria-label': point.label, 'data-row': point.row,
        onclick: () => choose(point.row), onkeydown: (event) => event.key === 'Enter' && choose(point.row),
      });
      svg.append(hint(mark, point.label));
    }
    const last = points[points.length - 1];
    labels.push({ at: y(last.error), colour, name, orders });
  }
  // Labels that would lie on each other make room.
  labels.sort((a, b) => a.at - b.at);
  let free = top;
  for (const { at, colour, name, orders } of labels) {
    const place = Math.max(at, free);
    free = place + 22 + 16 * orders.length;
    svg.append(drawn('text', { x: width - right + 12, y: place + 4, style: `fill: ${colour}; font-weight: 600` }, name));
    orders.forEach(({ cost, exponent, standard_error: spread, note }, i) => {
      const power = number(exponent, 2) + (spread === null ? '' : ` ± ${number(spread, 1)}`);
      svg.append(drawn('text', { x: width - right + 12, y: place + 20 + 16 * i }, note ?? `∝ ${cost}^(${power})`));
    });
  }
  host.replaceChildren(svg);
}

/** How many p-values are in each part of 0 to 1. */
function histogram(host, significance) {
  if (!significance || !significance.tests) {
    host.replaceChildren(element('p', { class: 'muted' }, 'Neither film has error bars: nothing can be tested.'));
    return;
  }
  const [width, height, left, bottom, top] = [560, 190, 12, 30, 14];
  const bins = significance.histogram;
  const expected = significance.tests / bins.length;
  const most = Math.max(...bins, expected);
  const step = (width - 2 * left) / bins.length;
  const y = (value) => height - bottom - (value / most) * (height - bottom - top);
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'histogram of p-values' });
  bins.forEach((value, i) => {
    const from = i / bins.length;
    const to = (i + 1) / bins.length;
    svg.append(hint(drawn('rect', { class: 'bin', x: left + i * step + 1, width: step - 2, y: y(value), height: height - bottom - y(value) }),
      `p from ${from.toFixed(2)} to ${to.toFixed(2)}: ${count(value)} of ${count(significance.tests)}`));
  });
  svg.append(
    drawn('line', { class: 'axis', x1: left, x2: width - left, y1: height - bottom, y2: height - bottom }),
    drawn('line', { class: 'expected', x1: left, x2: width - left, y1: y(expected), y2: y(expected) }),
    ...[0, 0.5, 1].map((p) => drawn('text', { x: left + p * (width - 2 * left), y: height - 10, 'text-anchor': ['start', 'middle', 'end'][2 * p] }, String(p))),
  );
  const { uniformity } = significance;
  const says = significance.has_bounds
    ? 'Against bounds, texels within them count as no difference: p-values near 1 are then too many by design.'
    : uniformity ? `Uniform where both films agree and their bars are right (dashed); χ² test: p = ${number(uniformity.p, 3)}.`
      : 'Too few tests for a χ² test.';
  host.replaceChildren(svg, element('p', { class: 'note' }, says));
}
