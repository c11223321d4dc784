'use strict';
// Numbers as text, elements by hand, and colour scales.

/** A number with so many significant digits; powers of ten where it is very large or small. */
function number(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    return `${mantissa} × 10${superscript(Number(exponent))}`.replace('-', '−');
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(decimals, 10)).replace('-', '−');
}

function superscript(exponent) {
  return String(exponent).replace(/./g, (c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'['0123456789'.indexOf(c)] ?? '⁻');
}

/** A fraction in percent. */
function percent(value, digits = 3) {
  return value === null || value === undefined ? '–' : `${number(100 * value, digits)} %`;
}

/** A fraction in percent, with its sign. */
function signedPercent(value, digits = 3) {
  return value > 0 ? `+${percent(value, digits)}` : percent(value, digits);
}

/** A length in metres, in the unit that suits it. */
function length(metres) {
  if (metres === null || metres === undefined) return '–';
  if (metres < 0.01) return `${number(1000 * metres, 3)} mm`;
  return metres < 1 ? `${number(100 * metres, 3)} cm` : `${number(metres, 3)} m`;
}

/** A count, grouped by thin spaces. */
function count(value) {
  return value === null || value === undefined ? '–' : String(value).replace(/\B(?=(\d{3})+(?!\d))/g, '\u2009');
}

/** An element with attributes and children; texts are texts, never markup. */
function element(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

/** The same for SVG. */
function drawn(name, attributes = {}, ...children) {
  return filled(document.createElementNS('http://www.w3.org/2000/svg', name), attributes, children);
}

function filled(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
    else node.setAttribute(key, value === true ? '' : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** Stops of the scales, from matplotlib's inferno and RdBu, which are in the public domain. */
const STOPS = {
  light: ['#000004', '#1b0c41', '#4a0c6b', '#781c6d', '#a52c60', '#cf4446', '#ed6925', '#fb9b06', '#f7d13d', '#fcffa4'],
  signed: ['#053061', '#2166ac', '#4393c3', '#92c5de', '#d1e5f0', '#f7f7f7', '#fddbc7', '#f4a582', '#d6604d', '#b2182b', '#67001f'],
  grey: ['#000000', '#ffffff'],
};

/** 256 colours along a scale, as bytes. */
function colours(scale) {
  const stops = STOPS[scale].map((text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16)));
  const table = new Uint8ClampedArray(256 * 3);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c++) table[3 * i + c] = stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]);
  }
  return table;
}

/** Ticks at 1, 2 and 5 times powers of ten within a range, or at powers of ten only where there are many. */
function logTicks(low, high) {
  const decades = Math.log10(high / low);
  const steps = decades > 3 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 5];
  const ticks = [];
  for (let exponent = Math.floor(Math.log10(low)); exponent <= Math.ceil(Math.log10(high)); exponent++) {
    for (const step of steps) {
      const value = step * 10 ** exponent;
      if (value >= low * 0.999 && value <= high * 1.001) ticks.push(value);
    }
  }
  return ticks;
}

/** A short number for a tick. */
function tick(value) {
  const size = Math.abs(value);
  if (value === 0) return '0';
  if (size >= 1e4 || size < 1e-3) {
    const exponent = Math.floor(Math.log10(size) + 1e-9);
    const mantissa = Math.round(value / 10 ** exponent);
    return `${mantissa === 1 ? '' : `${mantissa} × `}10${superscript(exponent)}`;
  }
  return String(Number(value.toPrecision(3))).replace('-', '−');
}
