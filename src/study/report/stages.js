// Waterfalls: how an approximation's error falls as its stages become exact, one after the other.

/** One waterfall: { error, stages: [{ stage, variant, exact, alone, cumulative }], residual } */
function waterfall({ label, error, stages, residual }, colour) {
  const [width, height, left, right, top, bottom] = [900, 260, 70, 20, 26, 58];
  const steps = [{ name: 'as set', from: 0, to: error, whole: true }];
  let before = error;
  for (const { stage, cumulative } of stages) {
    steps.push({ name: stage, from: before, to: cumulative });
    before = cumulative;
  }
  steps.push({ name: 'all exact', from: 0, to: residual, whole: true });
  const most = Math.max(...steps.flatMap(({ from, to }) => [from, to])) || 1;
  const slot = (width - left - right) / steps.length;
  const y = (value) => height - bottom - (value / most) * (height - top - bottom);
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `error of ${label}, stage by stage` });
  for (const part of [0, 0.5, 1]) {
    svg.append(drawn('line', { class: 'grid', x1: left, x2: width - right, y1: y(part * most), y2: y(part * most) }),
      drawn('text', { x: left - 8, y: y(part * most) + 4, 'text-anchor': 'end' }, percent(part * most)));
  }
  steps.forEach(({ name, from, to, whole }, i) => {
    const x = left + (i + 0.15) * slot;
    const rises = !whole && to > from;
    const bar = drawn('rect', {
      class: whole ? 'whole' : rises ? 'rise' : 'fall', x, width: 0.7 * slot, y: y(Math.max(from, to)),
      height: Math.max(1, Math.abs(y(from) - y(to))), style: whole || !rises ? `fill: ${colour}` : null,
    });
    const change = whole ? percent(to) : signedPercent(to - from);
    svg.append(
      hint(bar, whole ? `${name}: ${change}` : `${name} exact: ${change}, which leaves ${percent(to)}`),
      drawn('text', { x: x + 0.35 * slot, y: y(Math.max(from, to)) - 6, 'text-anchor': 'middle' }, change),
      drawn('text', { class: 'title', x: x + 0.35 * slot, y: height - bottom + 20, 'text-anchor': 'middle' }, name),
    );
    if (i + 1 < steps.length) {
      svg.append(drawn('line', { class: 'axis', x1: x + 0.7 * slot, x2: x + slot, y1: y(to), y2: y(to), 'stroke-dasharray': '2 3' }));
    }
  });
  svg.append(drawn('line', { class: 'axis', x1: left, x2: width - right, y1: y(0), y2: y(0) }));
  return element('div', { class: 'plot' }, svg);
}

/** An approximation's waterfall with its table. */
function stageErrors(one, colour) {
  const table = element('table');
  const error = (title, key) => ({ title, value: (stage) => stage[key], show: (stage) => percent(stage[key]) });
  sortable(table, [
    { title: 'stage', text: true, value: (stage) => stage.stage, show: (stage) => stage.stage },
    { title: 'as set', text: true, value: (stage) => stage.variant, show: (stage) => stage.variant },
    error('alone', 'alone'), error('with all before', 'cumulative'),
  ], one.stages);
  return [
    element('h3', {}, `${one.label}, ${one.layer}`),
    waterfall(one, colour),
    element('p', { class: 'lead' }, `Error ${percent(one.error)}; with all stages exact ${percent(one.residual)}; interaction ${signedPercent(one.interaction)}. `
      + `${percent(one.not_modelled)} of the light from mirrors and glass is not modelled at all.`),
    element('div', { class: 'scroll' }, table),
  ];
}
