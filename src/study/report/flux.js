// What each stage of a technique does to the flux, from the light to the image.

/** entries: [{ stage, reason, flux, photons }], the first of what sets out; energy: of the image, by the truth's */
function stageFlux(host, entries, energy) {
  const [width, left, right, top, row] = [900, 330, 110, 8, 22];
  let at = 0;
  const steps = entries.map(({ stage, reason, flux, photons }) => {
    const step = { name: `${stage}: ${reason}`, from: at, to: at + flux, flux, photons };
    at += flux;
    return step;
  });
  const image = at;
  steps.push({ name: 'the image', from: 0, to: image, flux: image, whole: true });
  if (energy) steps.push({ name: 'the truth', from: 0, to: image / energy, flux: image / energy, whole: true });
  steps[0].whole = true;
  const ends = steps.flatMap(({ from, to }) => [from, to]);
  const [least, most] = [Math.min(0, ...ends), Math.max(...ends) || 1];
  const x = (flux) => left + ((flux - least) / (most - least)) * (width - left - right);
  const height = 2 * top + row * steps.length;
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'flux, stage by stage' });
  steps.forEach(({ name, from, to, flux, photons, whole }, i) => {
    const y = top + i * row;
    const bar = drawn('rect', {
      class: whole ? 'whole' : flux < 0 ? 'rise' : 'fall', x: Math.min(x(from), x(to)), width: Math.max(1, Math.abs(x(to) - x(from))),
      y: y + 3, height: row - 6, style: whole || flux >= 0 ? 'fill: var(--c0)' : null,
    });
    const text = `${whole || flux <= 0 ? '' : '+'}${number(flux, 4)} W`;
    svg.append(
      drawn('text', { x: left - 8, y: y + row / 2 + 4, 'text-anchor': 'end' }, name),
      hint(bar, `${name}\n${text}${photons ? `, ${count(photons)} photons` : ''}`),
      drawn('text', { x: Math.max(x(from), x(to)) + 6, y: y + row / 2 + 4 }, text),
    );
  });
  host.replaceChildren(svg);
}
