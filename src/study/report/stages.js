// Stages: what each adds to a figure of an approximation (Shapley's values, with signs), and the table behind it.

const FIGURES = {
  l1: { name: 'L1', show: (value) => percent(value), meaning: 'sum of absolute differences over the truth’s sum; a black image has 100 %' },
  energy: { name: 'energy', show: (value) => signedPercent(value), meaning: 'flux over the truth’s, less one' },
  misplaced: { name: 'misplaced', show: (value) => percent(value), meaning: 'light in a wrong texel, at equal flux' },
  displaced: { name: 'displaced', show: (value) => `${number(value, 3)} texels`, meaning: 'how far light is from its place, on average' },
  l2: { name: 'L2', show: (value) => percent(value), meaning: 'root of the sum of squared differences over that of the truth’s squares' },
};

/** A value of a figure with its sign. */
function signedFigure(figure, value) {
  const text = FIGURES[figure].show(value);
  return value > 0 && !text.startsWith('+') ? `+${text}` : text;
}

/** Bars of what stages add, one under the other from where the one before ends, and what is left at the end. */
function shapleyBars({ label, stages }, shares, colour) {
  const [width, height, left, right, top, bottom] = [900, 260, 84, 20, 26, 58];
  let at = 0;
  const steps = [{ name: 'all exact', from: 0, to: shares.residual, whole: true }];
  at = shares.residual;
  stages.forEach(({ name }, i) => {
    const { value, standard_error: error } = shares.stages[i];
    steps.push({ name, from: at, to: at + value, error });
    at += value;
  });
  steps.push({ name: 'as set', from: 0, to: shares.whole, whole: true });
  const ends = steps.flatMap(({ from, to }) => [from, to]);
  const [least, most] = [Math.min(0, ...ends), Math.max(0, ...ends)];
  const range = most - least || 1;
  const slot = (width - left - right) / steps.length;
  const y = (value) => height - bottom - ((value - least) / range) * (height - top - bottom);
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${shares.figure} of ${label}, stage by stage` });
  for (const part of [0, 0.5, 1]) {
    const value = least + part * range;
    svg.append(drawn('line', { class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value) }),
      drawn('text', { x: left - 8, y: y(value) + 4, 'text-anchor': 'end' }, FIGURES[shares.figure].show(value)));
  }
  steps.forEach(({ name, from, to, whole, error }, i) => {
    const x = left + (i + 0.15) * slot;
    // Against the figure's own sign: less light is an error below zero.
    const hides = !whole && (to - from) * (shares.whole - shares.residual) < 0;
    const bar = drawn('rect', {
      class: whole ? 'whole' : hides ? 'rise' : 'fall', x, width: 0.7 * slot, y: y(Math.max(from, to)),
      height: Math.max(1, Math.abs(y(from) - y(to))), style: whole || !hides ? `fill: ${colour}` : null,
    });
    const change = whole ? FIGURES[shares.figure].show(to) : signedFigure(shares.figure, to - from);
    const spread = error > 0 ? ` ± ${FIGURES[shares.figure].show(error).replace('+', '')}` : '';
    svg.append(
      hint(bar, whole ? `${name}: ${change}` : `${name} ${hides ? 'hides' : 'adds'} ${change}${spread}`),
      drawn('text', { x: x + 0.35 * slot, y: y(Math.max(from, to)) - 6, 'text-anchor': 'middle' }, change),
      drawn('text', { class: 'title', x: x + 0.35 * slot, y: height - bottom + 20, 'text-anchor': 'middle' }, name),
    );
    if (i + 1 < steps.length) {
      svg.append(drawn('line', { class: 'axis', x1: x + 0.7 * slot, x2: x + slot, y1: y(to), y2: y(to), 'stroke-dasharray': '2 3' }));
    }
  });
  svg.append(drawn('line', { class: 'axis', x1: left, x2: width - right, y1: y(0), y2: y(0) }));
  return svg;
}

/** An approximation's stages: what stands on the page, with a choice of the figure, and a function that shows one. */
function stageErrors(one, colour, choice) {
  const host = element('div');
  function show(chosen) {
    const shares = one.figures.find(({ figure }) => figure === chosen);
    if (!shares) {
      host.replaceChildren(element('p', { class: 'muted' }, `${FIGURES[chosen].name} is not defined for all subsets of stages, as where some of them make a black image.`));
      return;
    }
    const { show: text, meaning } = FIGURES[shares.figure];
    const rows = one.stages.map((stage, i) => ({ ...stage, ...shares.stages[i] }));
    const column = (title, key, shown = text) => ({ title, value: (row) => row[key], show: (row) => shown(row[key]) });
    const table = element('table');
    sortable(table, [
      { title: 'stage', text: true, value: (row) => row.name, show: (row) => row.name },
      { title: 'as set', text: true, value: (row) => row.variant, show: (row) => row.variant },
      column('adds', 'value', (value) => signedFigure(shares.figure, value)),
      column('if it is exact', 'fixed'), column('if it alone is not', 'spoiled'), column('exact up to it', 'cumulative'),
    ], rows);
    const plot = element('div', { class: 'plot' }, shapleyBars(one, shares, colour));
    host.replaceChildren(
      plot, exportButtons(plot, `${one.name}-stages-${shares.figure}`),
      element('p', { class: 'lead' }, `${FIGURES[shares.figure].name} (${meaning}): ${text(shares.whole)}; with all stages exact ${text(shares.residual)}. `
        + `${one.not_modelled === null ? 'An unknown part' : percent(one.not_modelled)} of the light from mirrors and glass is not modelled at all.`),
      element('div', { class: 'scroll' }, table),
    );
  }
  const noise = one.twin_error == null ? '' : `; exact twins have ${percent(one.twin_error)} of noise`;
  const nodes = [
    element('h3', {}, `${one.label}, ${one.light}`),
    element('div', { class: 'controls' }, choice,
      element('span', { class: 'muted' }, `${one.runs} subsets of stages, on ${one.size.join(' × ')} texels${noise}`)),
    host,
  ];
  return { nodes, show };
}
