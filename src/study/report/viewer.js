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
  flip: { name: 'FLIP', unit: '' },
  relativeBar: { name: 'the truth’s bar by its value', unit: '%' },
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
    this.state = { colours: 'light', scale: 'log', exposure: 0, map: 'relative', wipe: false, at: 0.5, flipped: false };
    this.view = { x: this.width / 2, y: this.height / 2, zoom: 1 };
    this.panes = ['truth', 'run', 'map'].map((kind) => this.pane(kind));
    host.append(...this.panes.map((pane) => pane.figure));
    new ResizeObserver(() => this.draw()).observe(host);
  }

  pane(kind) {
    const canvas = element('canvas');
    const marks = element('canvas', { class: 'marks', 'aria-hidden': 'true' });
    const frame = element('div', { class: 'pane', tabindex: 0, role: 'img', style: `aspect-ratio: ${this.width} / ${this.height}` }, canvas, marks);
    const name = element('b');
    const range = element('span', { class: 'muted' });
    const scale = drawn('svg', { class: 'scale' });
    const figure = element('figure', { 'data-pane': kind }, element('figcaption', {}, name, range), frame, scale);
    const pane = { kind, canvas, marks, frame, name, range, scale, figure };
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
  async show(row, against = null) {
    const serial = (this.serial ?? 0) + 1;
    this.serial = serial;
    const file = against ? this.fileOf(against, this.layer || row.layer) : this.truthOf(row);
    const film = this.fileOf(row);
    const [reference, own, referenceBar, ownBar, ownZ, ownFlip] = await Promise.all([
      this.numbers(file, 'value'), this.numbers(film, 'value'),
      this.numbers(file, 'bar'), this.numbers(film, 'bar'), this.numbers(film, 'z'), this.numbers(film, 'flip'),
    ]);
    // Both are taken against the truth.
    const [z, flip] = against ? [null, null] : [ownZ, ownFlip];
    const colour = (film, grey) => Promise.all(['red', 'green', 'blue'].map((kind) => this.numbers(film, kind)))
      .then((channels) => (channels[0] ? channels : [grey, grey, grey]));
    const coloured = this.hasColour ? { truth: await colour(file, reference), run: await colour(film, own) } : null;
    // Another run, light or reference may have been chosen in the meantime.
    if (this.serial !== serial) return;
    this.row = row;
    this.against = against;
    this.coloured = coloured;
    const difference = own.map((value, i) => value - reference[i]);
    const relative = difference.map((value, i) => (reference[i] > 0 ? (100 * value) / reference[i] : NaN));
    const relativeBar = referenceBar ? referenceBar.map((bar, i) => (reference[i] > 0 ? (100 * bar) / reference[i] : NaN)) : null;
    this.films = { truth: reference, run: own, difference, relative, z, flip, relativeBar, referenceBar, ownBar };
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
    this.reach.flip = 1;
    this.reach.relativeBar = relativeBar ? Math.min(100, percentile(relativeBar, 0.99)) || 1 : 1;
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
      const map = this.films[this.state.map] ? this.state.map : 'relative';
      const reach = this.reach[map] * stops;
      const isSigned = !['flip', 'relativeBar'].includes(map);
      if (!isSigned) return { values: this.films[map], low: 0, high: reach, colours: 'light', unit: MAPS[map].unit };
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
      this.paint(pane, this.state.flipped && pane.kind === 'truth' ? 'run' : pane.kind, 0, 1);
      pane.frame.querySelector('.bladed')?.remove();
      if (wipe && pane.kind === 'truth') {
        this.paint(pane, 'run', at, 1);
        pane.frame.append(element('div', { class: 'bladed', style: `left: ${100 * at}%` }));
      }
      this.mark(pane);
      this.label(pane);
    }
  }

  /** The film that is beside the run: the truth's layer that the row is judged by. */
  truthOf(row) {
    const layer = this.fileOf(row).split('#')[1] ?? row.layer;
    const ofLayer = `${this.data.truth}#${layer}`;
    return this.planes.has(`${ofLayer} value`) ? ofLayer : this.data.truth;
  }

  /** The film of a row: the layer that is chosen, if it has it, or else the light that it is judged by. */
  fileOf(row, layer = this.layer) {
    const ofLayer = `${row.file}#${layer}`;
    return layer && this.planes.has(`${ofLayer} value`) ? ofLayer : row.file;
  }

  /** True if a film has the light that is shown of a row. */
  hasLight(other, row) {
    const layer = this.layer || row.layer;
    return other.layer === layer || this.fileOf(other, layer) !== other.file;
  }

  /** The layers that are there by themselves. */
  layers() {
    const named = [...this.planes.values()].filter(({ kind }) => kind === 'value').map(({ file }) => file.split('#'));
    return [...new Set(named.filter(([file, layer]) => layer && file !== this.data.truth).map(([, layer]) => layer))];
  }

  /** Draws the region and the line of the profile. */
  mark(pane) {
    Object.assign(pane.marks, { width: pane.canvas.width, height: pane.canvas.height });
    const context = pane.marks.getContext('2d');
    const size = this.view.zoom * (pane.canvas.width / this.width);
    const place = (x, y) => [pane.canvas.width / 2 + (x - this.view.x) * size, pane.canvas.height / 2 + (y - this.view.y) * size];
    context.lineWidth = window.devicePixelRatio || 1;
    if (this.region) {
      const { x, y, width, height } = this.region;
      context.strokeStyle = '#00e5ff';
      context.strokeRect(...place(x, y), width * size, height * size);
    }
    if (this.line) {
      context.strokeStyle = 'rgba(0, 229, 255, .6)';
      context.beginPath();
      const { isRow, at } = this.line;
      context.moveTo(...(isRow ? place(0, at + 0.5) : place(at + 0.5, 0)));
      context.lineTo(...(isRow ? place(this.width, at + 0.5) : place(at + 0.5, this.height)));
      context.stroke();
    }
  }

  /** The region, or else all, as one picture: reference, run and map, each texel a square. */
  inset() {
    const { x, y, width, height } = this.region ?? { x: 0, y: 0, width: this.width, height: this.height };
    const scale = Math.max(1, Math.floor(384 / Math.max(width, height)));
    const gap = 8;
    const canvas = element('canvas', { width: 3 * width * scale + 2 * gap, height: height * scale });
    const context = canvas.getContext('2d');
    context.imageSmoothingEnabled = false;
    ['truth', 'run', 'map'].forEach((kind, i) => context.drawImage(this.picture(kind), x, y, width, height, i * (width * scale + gap), 0, width * scale, height * scale));
    return new Promise((done) => { canvas.toBlob(done); });
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
    const reference = this.against ? this.against.label : 'truth';
    const map = this.films[this.state.map] ? this.state.map : 'relative';
    const names = { truth: this.state.flipped ? this.row.label : reference, run: this.row.label, map: MAPS[map].name };
    pane.name.textContent = this.state.wipe && pane.kind === 'truth' ? `${reference} | ${this.row.label}` : names[pane.kind];
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
    const start = this.texel(pane, event);
    const move = (now) => {
      if (event.shiftKey) {
        this.select(start, this.texel(pane, now));
      } else if (isBlade) {
        this.state.at = Math.min(1, Math.max(0, part(now)));
      } else {
        const size = this.view.zoom * (box.width / this.width);
        this.view.x -= (now.clientX - last.clientX) / size;
        this.view.y -= (now.clientY - last.clientY) / size;
      }
      last = now;
      this.draw();
    };
    const up = (now) => {
      pane.frame.removeEventListener('pointermove', move);
      pane.frame.removeEventListener('pointerup', up);
      pane.frame.removeEventListener('pointercancel', up);
      if (now.type === 'pointercancel') return;
      const end = this.texel(pane, now);
      const isClick = Math.hypot(now.clientX - event.clientX, now.clientY - event.clientY) < 3;
      if (isClick) this.host.dispatchEvent(new CustomEvent('place', { detail: end }));
      if (event.shiftKey) this.host.dispatchEvent(new CustomEvent('region'));
    };
    pane.frame.addEventListener('pointermove', move);
    pane.frame.addEventListener('pointerup', up);
    pane.frame.addEventListener('pointercancel', up);
  }

  /** Chooses the texels between two places. */
  select(from, to) {
    const within = (value, most) => Math.min(most - 1, Math.max(0, Math.floor(value)));
    const [x0, x1] = [from.x, to.x].map((x) => within(x, this.width)).sort((a, b) => a - b);
    const [y0, y1] = [from.y, to.y].map((y) => within(y, this.height)).sort((a, b) => a - b);
    this.region = { x: x0, y: y0, width: x1 - x0 + 1, height: y1 - y0 + 1 };
  }

  /** Chooses the texels that are seen. */
  selectSeen() {
    const half = { x: this.width / (2 * this.view.zoom), y: this.height / (2 * this.view.zoom) };
    this.select({ x: this.view.x - half.x, y: this.view.y - half.y }, { x: this.view.x + half.x - 1e-9, y: this.view.y + half.y - 1e-9 });
    this.host.dispatchEvent(new CustomEvent('region'));
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
      w: () => this.set({ wipe: !this.state.wipe }), f: () => this.set({ flipped: !this.state.flipped }),
      '[': () => this.set({ at: Math.max(0, this.state.at - 0.05) }), ']': () => this.set({ at: Math.min(1, this.state.at + 0.05) }),
      x: () => this.host.dispatchEvent(new CustomEvent('place', { detail: { x: this.view.x, y: this.view.y } })),
      r: () => this.selectSeen(), n: () => turn(1), p: () => turn(-1),
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
      element('span', {}, `${this.against ? this.against.label : 'truth'} `, element('b', {}, number(truth[i], 5) + bar(referenceBar)), ` ${this.unit}`),
      element('span', {}, `${this.row.label} `, element('b', {}, number(run[i]) + bar(ownBar)), ` ${this.unit}`),
      element('span', {}, 'difference ', element('b', {}, sign + number(difference[i])),
        Number.isNaN(relative[i]) ? '' : ` (${sign}${number(relative[i], 3)} %)`,
        z && Number.isFinite(z[i]) ? `, z ${number(z[i], 2)}` : ''),
    );
  }
}
