// Films side by side: one view for all panes, false colours, a wipe, and the texel under the pointer.

/** A plane's numbers: four planes of bytes, deflated, most significant first. */
async function decode(plane) {
  const packed = Uint8Array.from(atob(plane.data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const n = bytes.length / 4;
  const numbers = new DataView(new ArrayBuffer(bytes.length));
  for (let i = 0; i < n; i++) {
    for (let byte = 0; byte < 4; byte++) numbers.setUint8(4 * i + byte, bytes[byte * n + i]);
  }
  return Float32Array.from({ length: n }, (_, i) => numbers.getFloat32(4 * i));
}

/** The value that a part of the finite ones does not exceed. */
function percentile(values, part) {
  const sorted = values.filter(Number.isFinite).sort();
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] : 0;
}

/** Linear light (0 to 1) on a screen: the curve of sRGB. */
function screen(light) {
  const part = Math.min(1, Math.max(0, light));
  return part <= 0.0031308 ? 12.92 * part : 1.055 * part ** (1 / 2.4) - 0.055;
}

const MAPS = {
  relative: { name: 'relative difference', unit: '%' },
  difference: { name: 'difference', unit: null },
  z: { name: 'difference in standard errors', unit: 'σ' },
};

class Viewer {
  /** pictures: { size, step, planes, unit, truth: the truth's file, name: of the viewer, for ids } */
  constructor(pictures, host, readout) {
    this.data = pictures;
    [this.width, this.height] = pictures.size;
    this.host = host;
    this.readout = readout;
    this.unit = pictures.unit;
    this.hasColour = pictures.planes.some((plane) => plane.kind === 'red');
    this.planes = new Map(pictures.planes.map((plane) => [`${plane.file} ${plane.kind}`, plane]));
    this.decoded = new Map();
    this.pictures = new Map();
    this.state = { colours: 'light', scale: 'log', exposure: 0, map: 'relative', wipe: false, at: 0.5 };
    this.view = { x: this.width / 2, y: this.height / 2, zoom: 1 };
    this.panes = ['truth', 'run', 'map'].map((kind) => this.pane(kind));
    host.append(...this.panes.map((pane) => pane.figure));
    new ResizeObserver(() => this.draw()).observe(host);
  }

  pane(kind) {
    const canvas = element('canvas');
    const frame = element('div', { class: 'pane', tabindex: 0, role: 'img', style: `aspect-ratio: ${this.width} / ${this.height}` }, canvas);
    const name = element('b');
    const range = element('span', { class: 'muted' });
    const scale = drawn('svg', { class: 'scale' });
    const figure = element('figure', { 'data-pane': kind }, element('figcaption', {}, name, range), frame, scale);
    const pane = { kind, canvas, frame, name, range, scale, figure };
    frame.addEventListener('wheel', (event) => {
      // Who scrolls past is not to be caught: only a pane in focus zooms, or a pinch, which comes with ctrlKey.
      if (document.activeElement !== frame && !event.ctrlKey) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), this.texel(pane, event));
    }, { passive: false });
    frame.addEventListener('pointerdown', (event) => this.grab(pane, event));
    frame.addEventListener('pointermove', (event) => this.read(this.texel(pane, event)));
    frame.addEventListener('dblclick', () => this.fit());
    frame.addEventListener('keydown', (event) => this.key(event));
    return pane;
  }

  /** The numbers of a film, decoded once. */
  async numbers(file, kind) {
    const key = `${file} ${kind}`;
    if (!this.decoded.has(key)) {
      const plane = this.planes.get(key);
      this.decoded.set(key, plane ? await decode(plane) : null);
    }
    return this.decoded.get(key);
  }

  /** Shows a row of the report. */
  async show(row) {
    this.wanted = row;
    const { truth } = this.data;
    const ofLayer = `${truth}#${row.layer}`;
    const file = this.planes.has(`${ofLayer} value`) ? ofLayer : truth;
    const [reference, own, referenceBar, ownBar, z] = await Promise.all([
      this.numbers(file, 'value'), this.numbers(row.file, 'value'),
      this.numbers(file, 'bar'), this.numbers(row.file, 'bar'), this.numbers(row.file, 'z'),
    ]);
    const colour = (film, grey) => Promise.all(['red', 'green', 'blue'].map((kind) => this.numbers(film, kind)))
      .then((channels) => (channels[0] ? channels : [grey, grey, grey]));
    const coloured = this.hasColour ? { truth: await colour(file, reference), run: await colour(row.file, own) } : null;
    // Another run may have been chosen in the meantime.
    if (this.wanted !== row) return;
    this.row = row;
    this.coloured = coloured;
    const difference = own.map((value, i) => value - reference[i]);
    const relative = difference.map((value, i) => (reference[i] > 0 ? (100 * value) / reference[i] : NaN));
    this.films = { truth: reference, run: own, difference, relative, z, referenceBar, ownBar };
    this.top = percentile(reference, 1) || 1;
    this.white = percentile(reference, 0.995) || this.top || 1;
    this.bottom = Math.max(percentile(reference.filter((value) => value > 0), 0.005), this.top * 1e-6) || 1e-6;
    this.reach = {};
    for (const map of ['difference', 'relative']) {
      this.reach[map] = percentile(this.films[map].map(Math.abs), 0.99) || 1;
    }
    // Beyond the double there is only dark that noise falls on; it would hide the rest.
    this.reach.relative = Math.min(this.reach.relative, 100);
    this.reach.z = 5;
    this.pictures.clear();
    this.draw();
    this.read(this.last);
  }

  set(changes) {
    Object.assign(this.state, changes);
    this.pictures.clear();
    this.draw();
    this.host.dispatchEvent(new CustomEvent('viewer'));
  }

  /** What a pane shows: numbers, a range and a scale of colours. */
  content(kind) {
    const stops = 2 ** -this.state.exposure;
    if (kind === 'map') {
      const map = this.films.z || this.state.map !== 'z' ? this.state.map : 'relative';
      const reach = this.reach[map] * stops;
      return { values: this.films[map], low: -reach, high: reach, colours: 'signed', unit: MAPS[map].unit ?? this.unit };
    }
    const isLog = this.state.scale === 'log';
    const high = (isLog ? this.top : this.white) * stops;
    const low = isLog ? Math.min(this.bottom * stops, high / 10) : 0;
    return { values: this.films[kind], low, high, isLog, colours: this.state.colours, unit: this.unit };
  }

  /** A film as a picture of one pixel a texel. */
  picture(kind) {
    if (this.pictures.has(kind)) return this.pictures.get(kind);
    const { values, low, high, isLog, colours: scale } = this.content(kind);
    const table = colours(scale === 'rgb' ? 'grey' : scale);
    const image = new ImageData(this.width, this.height);
    const [from, to] = isLog ? [Math.log(low), Math.log(high)] : [low, high];
    const isGrey = scale === 'grey' && !isLog;
    for (let i = 0; i < values.length; i++) {
      let part = ((isLog ? Math.log(Math.max(values[i], 0)) : values[i]) - from) / (to - from);
      if (Number.isNaN(part)) {
        image.data.set(kind === 'map' ? [128, 128, 128, 255] : [255, 0, 255, 255], 4 * i);
        continue;
      }
      if (scale === 'rgb') {
        // The scale is that of the mean; channels keep their ratios to it, and are cut off where they are beyond the screen's.
        const factor = isLog ? Math.max(0, part) / (values[i] || 1) : 1 / high;
        for (let c = 0; c < 3; c++) image.data[4 * i + c] = 255 * screen(this.coloured[kind][c][i] * factor);
        image.data[4 * i + 3] = 255;
        continue;
      }
      part = Math.min(1, Math.max(0, part));
      if (isGrey) part = screen(part);
      const colour = 3 * Math.round(255 * part);
      image.data[4 * i] = table[colour];
      image.data[4 * i + 1] = table[colour + 1];
      image.data[4 * i + 2] = table[colour + 2];
      image.data[4 * i + 3] = 255;
    }
    const canvas = element('canvas', { width: this.width, height: this.height });
    canvas.getContext('2d').putImageData(image, 0, 0);
    this.pictures.set(kind, canvas);
    return canvas;
  }

  draw() {
    if (!this.films) return;
    const { wipe, at } = this.state;
    this.host.classList.toggle('wipe', wipe);
    for (const pane of this.panes) {
      pane.figure.hidden = wipe && pane.kind === 'run';
      if (pane.figure.hidden) continue;
      const { width, height } = pane.frame.getBoundingClientRect();
      const density = window.devicePixelRatio || 1;
      pane.canvas.width = Math.round(width * density);
      pane.canvas.height = Math.round(height * density);
      this.paint(pane, pane.kind, 0, 1);
      pane.frame.querySelector('.bladed')?.remove();
      if (wipe && pane.kind === 'truth') {
        this.paint(pane, 'run', at, 1);
        pane.frame.append(element('div', { class: 'bladed', style: `left: ${100 * at}%` }));
      }
      this.label(pane);
    }
  }

  /** Paints a film on the part of a pane between two of its widths. */
  paint(pane, kind, from, to) {
    const context = pane.canvas.getContext('2d');
    const { width, height } = pane.canvas;
    const size = this.view.zoom * (width / this.width);
    context.save();
    context.beginPath();
    context.rect(from * width, 0, (to - from) * width, height);
    context.clip();
    context.clearRect(0, 0, width, height);
    context.imageSmoothingEnabled = size < 1;
    context.drawImage(
      this.picture(kind),
      width / 2 - this.view.x * size, height / 2 - this.view.y * size, this.width * size, this.height * size,
    );
    context.restore();
  }

  label(pane) {
    const { low, high, isLog, colours: scale, unit } = this.content(pane.kind);
    const names = { truth: 'truth', run: this.row.label, map: MAPS[this.state.map].name };
    pane.name.textContent = this.state.wipe && pane.kind === 'truth' ? `truth | ${this.row.label}` : names[pane.kind];
    pane.range.textContent = unit;
    pane.frame.setAttribute('aria-label', `${pane.name.textContent}, from ${number(low)} to ${number(high)} ${unit}`);
    const id = `${this.data.name}-${pane.kind}`;
    const stops = STOPS[scale === 'rgb' ? 'grey' : scale].map((colour, i, all) => drawn('stop', { offset: i / (all.length - 1), 'stop-color': colour }));
    const places = isLog ? logTicks(low, high).map((value) => [value, Math.log(value / low) / Math.log(high / low)])
      : [0, 0.25, 0.5, 0.75, 1].map((part) => [low + part * (high - low), part]);
    pane.scale.replaceChildren(
      drawn('defs', {}, drawn('linearGradient', { id }, ...stops)),
      drawn('rect', { width: '100%', height: 9, rx: 1, fill: `url(#${id})` }),
      ...places.map(([value, part]) => drawn('text', {
        x: `${100 * part}%`, y: 24, 'text-anchor': part < 0.04 ? 'start' : part > 0.96 ? 'end' : 'middle',
      }, tick(value))),
    );
  }

  /** The place in texels under a pointer. */
  texel(pane, event) {
    const box = pane.frame.getBoundingClientRect();
    const size = this.view.zoom * (box.width / this.width);
    return {
      x: this.view.x + (event.clientX - box.left - box.width / 2) / size,
      y: this.view.y + (event.clientY - box.top - box.height / 2) / size,
    };
  }

  grab(pane, event) {
    pane.frame.setPointerCapture(event.pointerId);
    const box = pane.frame.getBoundingClientRect();
    const part = (e) => (e.clientX - box.left) / box.width;
    const isBlade = this.state.wipe && pane.kind === 'truth' && Math.abs(part(event) - this.state.at) < 0.03;
    let last = event;
    const move = (now) => {
      if (isBlade) {
        this.state.at = Math.min(1, Math.max(0, part(now)));
      } else {
        const size = this.view.zoom * (box.width / this.width);
        this.view.x -= (now.clientX - last.clientX) / size;
        this.view.y -= (now.clientY - last.clientY) / size;
      }
      last = now;
      this.draw();
    };
    const up = () => pane.frame.removeEventListener('pointermove', move);
    pane.frame.addEventListener('pointermove', move);
    pane.frame.addEventListener('pointerup', up, { once: true });
    pane.frame.addEventListener('pointercancel', up, { once: true });
  }

  zoom(factor, about = this.view) {
    const zoom = Math.min(64, Math.max(0.5, this.view.zoom * factor));
    const kept = this.view.zoom / zoom;
    this.view = { x: about.x + (this.view.x - about.x) * kept, y: about.y + (this.view.y - about.y) * kept, zoom };
    this.draw();
  }

  fit() {
    this.view = { x: this.width / 2, y: this.height / 2, zoom: 1 };
    this.draw();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = this.width / (16 * this.view.zoom);
    const pan = (x, y) => { this.view.x += x * step; this.view.y += y * step; this.draw(); this.read(this.view); };
    const turn = (by) => this.host.dispatchEvent(new CustomEvent('turn', { detail: by }));
    const act = {
      ArrowLeft: () => pan(-1, 0), ArrowRight: () => pan(1, 0), ArrowUp: () => pan(0, -1), ArrowDown: () => pan(0, 1),
      '+': () => this.zoom(1.5), '=': () => this.zoom(1.5), '-': () => this.zoom(1 / 1.5), 0: () => this.fit(),
      e: () => this.set({ exposure: this.state.exposure + 0.5 }), d: () => this.set({ exposure: this.state.exposure - 0.5 }),
      w: () => this.set({ wipe: !this.state.wipe }),
      '[': () => this.set({ at: Math.max(0, this.state.at - 0.05) }), ']': () => this.set({ at: Math.min(1, this.state.at + 0.05) }),
      n: () => turn(1), p: () => turn(-1),
    }[event.key];
    if (act) {
      event.preventDefault();
      act();
    }
  }

  /** Tells the values at a place. */
  read(place) {
    if (!this.films) return;
    const x = Math.floor(place?.x ?? -1);
    const y = Math.floor(place?.y ?? -1);
    if (x < 0 || y < 0 || x >= this.width || y >= this.height) {
      this.readout.replaceChildren(element('span', { class: 'muted' }, 'Point at a texel to read its values.'));
      return;
    }
    this.last = place;
    const { truth, run, difference, relative, z, referenceBar, ownBar } = this.films;
    const i = y * this.width + x;
    const { step } = this.data;
    const where = step === 1 ? `texel (${x}, ${y})` : `texels (${x * step}…, ${y * step}…), mean of ${step} × ${step}`;
    const bar = (bars) => (bars && Number.isFinite(bars[i]) ? ` ± ${number(bars[i], 2)}` : '');
    const sign = difference[i] > 0 ? '+' : '';
    this.readout.replaceChildren(
      element('span', { class: 'muted' }, where),
      element('span', {}, 'truth ', element('b', {}, number(truth[i], 5) + bar(referenceBar)), ` ${this.unit}`),
      element('span', {}, `${this.row.label} `, element('b', {}, number(run[i]) + bar(ownBar)), ` ${this.unit}`),
      element('span', {}, 'difference ', element('b', {}, sign + number(difference[i])),
        Number.isNaN(relative[i]) ? '' : ` (${sign}${number(relative[i], 3)} %)`,
        z && Number.isFinite(z[i]) ? `, z ${number(z[i], 2)}` : ''),
    );
  }
}
