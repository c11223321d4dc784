// L2 against the scale at which one looks, run by run.

/** runs: [{ label, colour, scales, chosen }] */
function scalePlot(host, { runs, metre, choose }) {
  const [width, height, left, right, top, bottom] = [900, 340, 74, 190, 26, 52];
  const all = runs.flatMap(({ scales }) => scales.filter(({ l2 }) => l2.value > 0));
  if (!all.length) {
    host.replaceChildren(element('p', { class: 'muted' }, 'No run differs from the truth at any scale.'));
    return;
  }
  const [x0, x1] = [0, Math.log10(Math.max(2, ...all.map(({ texels }) => texels)))];
  const [y0, y1] = padded([...all.map(({ l2 }) => l2.value), 0.1, 1], 0.5);
  const x = (texels) => left + ((Math.log10(texels) - x0) / (x1 - x0)) * (width - left - right);
  const y = (l2) => height - bottom - ((Math.log10(l2) - y0) / (y1 - y0)) * (height - top - bottom);
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'group', 'aria-label': 'L2 against scale' });
  for (const texels of [...new Set(all.map((one) => one.texels))]) {
    svg.append(drawn('line', { class: 'grid', x1: x(texels), x2: x(texels), y1: top, y2: height - bottom }),
      drawn('text', { x: x(texels), y: height - bottom + 18, 'text-anchor': 'middle' }, String(texels)));
  }
  for (const value of logTicks(100 * 10 ** y0, 100 * 10 ** y1)) {
    svg.append(drawn('line', { class: 'grid', x1: left, x2: width - right, y1: y(value / 100), y2: y(value / 100) }),
      drawn('text', { x: left - 8, y: y(value / 100) + 4, 'text-anchor': 'end' }, `${tick(value)} %`));
  }
  svg.append(
    drawn('line', { class: 'axis', x1: left, x2: width - right, y1: height - bottom, y2: height - bottom }),
    drawn('line', { class: 'axis', x1: left, x2: left, y1: top, y2: height - bottom }),
    drawn('text', { class: 'title', x: (left + width - right) / 2, y: height - 12, 'text-anchor': 'middle' },
      `side of the squares [texels]${metre ? `, one texel is ${number(metre, 3)} m` : ''}`),
    drawn('text', { class: 'title', x: left - 58, y: top - 9 }, 'L2 of means over squares'),
    hint(drawn('line', { class: 'expected', x1: left, x2: width - right, y1: y(1), y2: y(1) }), 'a black image'),
    hint(drawn('line', { class: 'expected', x1: left, x2: width - right, y1: y(0.1), y2: y(0.1) }), 'right to 10 %'),
    drawn('text', { x: width - right + 12, y: y(1) + 4, class: 'muted' }, 'black'),
    drawn('text', { x: width - right + 12, y: y(0.1) + 4, class: 'muted' }, 'right to 10 %'),
  );
  for (const { label, colour, scales, row, chosen } of runs) {
    const known = scales.filter(({ l2 }) => l2.value > 0);
    if (!known.length) continue;
    const path = known.map(({ texels, l2 }, i) => `${i ? 'L' : 'M'}${x(texels)} ${y(l2.value)}`).join('');
    svg.append(drawn('path', { class: 'curve', d: path, stroke: colour, 'stroke-width': chosen ? 3 : 1, opacity: chosen ? 1 : 0.45, 'data-row': row }));
    for (const { texels, l2 } of known) {
      const ends = l2.low === null ? '' : `\nbetween ${percent(l2.low)} and ${percent(l2.high)}`;
      const mark = drawn('circle', { cx: x(texels), cy: y(l2.value), r: chosen ? 5 : 3, fill: colour, opacity: chosen ? 1 : 0.6, tabindex: chosen ? 0 : null, onclick: () => choose(row) });
      svg.append(hint(mark, `${label}\nL2 ${percent(l2.value)} at ${texels} texels${ends}`));
    }
  }
  host.replaceChildren(svg);
}
