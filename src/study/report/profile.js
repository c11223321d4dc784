// A line across the light: the truth with its bars, and all runs that are judged by the same light.

/**
 * films: [{ label, colour, values, bar, chosen }], the truth first
 * line: { isRow, at }: a row or a column of the picture's texels, each of which is step of the film's
 * metre: of one texel of the film along the line
 */
function profilePlot(host, { films, line, size: [columns, rows], unit, step, metre }) {
  const [width, height, left, right, top, bottom] = [900, 340, 74, 190, 26, 52];
  const count = line.isRow ? columns : rows;
  const along = (values) => Array.from({ length: count }, (_, i) => values[line.isRow ? line.at * columns + i : i * columns + line.at]);
  const lines = films.map((film) => ({ ...film, line: along(film.values), bars: film.bar ? along(film.bar) : null }));
  const most = Math.max(...lines[0].line, ...lines.filter((one) => one.chosen).flatMap((one) => one.line)) || 1;
  const x = (i) => left + ((i + 0.5) / count) * (width - left - right);
  const y = (value) => height - bottom - Math.min(1.05, Math.max(0, value) / most) * (height - top - bottom);
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `profile along ${line.isRow ? 'row' : 'column'} ${line.at * step}` });
  for (const part of [0, 0.25, 0.5, 0.75, 1]) {
    svg.append(drawn('line', { class: 'grid', x1: left, x2: width - right, y1: y(part * most), y2: y(part * most) }),
      drawn('text', { x: left - 8, y: y(part * most) + 4, 'text-anchor': 'end' }, tick(part * most)));
    const texel = Math.round(part * (count - 1));
    svg.append(drawn('text', { x: x(texel), y: height - bottom + 18, 'text-anchor': 'middle' }, metre ? `${texel * step} (${length(texel * step * metre)})` : String(texel * step)));
  }
  const [truth] = lines;
  if (truth.bars) {
    const ends = (sign) => truth.line.map((value, i) => `${x(i)} ${y(value + sign * (truth.bars[i] || 0))}`);
    svg.append(drawn('path', { class: 'band', d: `M${ends(1).join('L')}L${ends(-1).reverse().join('L')}Z` }));
  }
  lines.slice().reverse().forEach(({ label, colour, line: values, chosen }, i) => {
    const isTruth = i === lines.length - 1;
    const path = drawn('path', {
      class: 'curve', d: `M${values.map((value, at) => `${x(at)} ${y(value)}`).join('L')}`, stroke: isTruth ? 'var(--ink)' : colour,
      'stroke-width': chosen || isTruth ? 2 : 1, opacity: chosen || isTruth ? 1 : 0.35,
    });
    svg.append(hint(path, label));
  });
  const named = lines.filter((one, i) => i === 0 || one.chosen);
  named.forEach(({ label, colour }, i) => svg.append(drawn('text', { x: width - right + 12, y: top + 16 + 20 * i, style: `fill: ${i ? colour : 'var(--ink)'}; font-weight: 600` }, label)));
  svg.append(
    drawn('line', { class: 'axis', x1: left, x2: width - right, y1: height - bottom, y2: height - bottom }),
    drawn('line', { class: 'axis', x1: left, x2: left, y1: top, y2: height - bottom }),
    drawn('text', { class: 'title', x: (left + width - right) / 2, y: height - 12, 'text-anchor': 'middle' }, `${line.isRow ? 'column' : 'row'} along ${line.isRow ? 'row' : 'column'} ${line.at * step}`),
    drawn('text', { class: 'title', x: left - 58, y: top - 9 }, unit),
  );
  host.replaceChildren(svg);
}

/** Mean, energy and L1 of films in a rectangle of texels; the truth first. */
function regionFigures(films, { x, y, width, height }, columns) {
  const of = (values) => {
    const found = [];
    for (let row = y; row < y + height; row++) for (let column = x; column < x + width; column++) found.push(values[row * columns + column]);
    return found;
  };
  const sum = (values) => values.reduce((all, value) => all + value, 0);
  const truth = of(films[0].values);
  const all = sum(truth);
  return films.map(({ label, values }) => {
    const own = of(values);
    return { label, mean: sum(own) / own.length, energy: all > 0 ? sum(own) / all : null, l1: all > 0 ? sum(own.map((value, i) => Math.abs(value - truth[i]))) / all : null };
  });
}
