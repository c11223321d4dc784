// What is seen as a file: plots as SVG and PNG, panes as PNG, tables as Markdown and LaTeX.

/** Offers bytes as a file of this name. */
function offer(name, blob) {
  const url = URL.createObjectURL(blob);
  element('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** A plot as SVG that needs no style sheet. */
function standalone(svg) {
  const copy = svg.cloneNode(true);
  const kept = ['fill', 'stroke', 'stroke-width', 'stroke-dasharray', 'font-family', 'font-size', 'font-weight', 'text-anchor', 'opacity'];
  const [from, to] = [svg, copy].map((root) => [root, ...root.querySelectorAll('*')]);
  from.forEach((node, i) => {
    const style = getComputedStyle(node);
    to[i].setAttribute('style', kept.map((key) => `${key}: ${style.getPropertyValue(key)}`).join('; '));
  });
  const [, , width, height] = svg.getAttribute('viewBox').split(' ');
  for (const [key, value] of Object.entries({ xmlns: 'http://www.w3.org/2000/svg', width, height })) copy.setAttribute(key, value);
  return new XMLSerializer().serializeToString(copy);
}

/** The same as PNG, of twice as many pixels. */
async function rasterised(svg) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(standalone(svg))}`;
  await image.decode();
  const canvas = element('canvas', { width: 2 * image.width, height: 2 * image.height });
  const context = canvas.getContext('2d');
  context.fillStyle = getComputedStyle(document.body).backgroundColor;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => { canvas.toBlob(done); });
}

/** Buttons that save the plot in a host. */
function exportButtons(host, name) {
  const svg = () => host.querySelector('svg');
  const button = (text, act) => element('button', { type: 'button', class: 'export', 'data-export': text, onclick: () => svg() && act() }, text);
  return element('span', { class: 'exports' },
    button('SVG', () => offer(`${name}.svg`, new Blob([standalone(svg())], { type: 'image/svg+xml' }))),
    button('PNG', async () => offer(`${name}.png`, await rasterised(svg()))));
}

/** The texts of a table, row by row, those without a title left out. */
function cells(table) {
  const [head, ...rows] = [...table.querySelectorAll('tr')].map((row) => [...row.children].map((cell) => cell.textContent.trim()));
  const kept = head.map((title, i) => [title, i]).filter(([title]) => title).map(([, i]) => i);
  return [head, ...rows].map((row) => kept.map((i) => row[i]));
}

function asMarkdown(table) {
  const [head, ...rows] = cells(table).map((row) => row.map((text) => text.replaceAll('|', '\\|')));
  const line = (row) => `| ${row.join(' | ')} |`;
  return [line(head), `|${head.map((_, i) => (i ? '--:' : '---')).join('|')}|`, ...rows.map(line)].join('\n');
}

function asLatex(table) {
  const plain = (text) => text.replace(/[\\{}_&%#$^~]/g, (c) => ({ '\\': '\\textbackslash{}', '^': '\\^{}', '~': '\\~{}' }[c] ?? `\\${c}`))
    .replaceAll('−', '$-$').replaceAll('–', '--').replaceAll('×', '$\\times$').replaceAll('●', '$\\bullet$')
    .replace(/[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+/g, (digits) => `$^{${[...digits].map((digit) => '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(digit)).map((i) => (i < 0 ? '-' : i)).join('')}}$`);
  const [head, ...rows] = cells(table).map((row) => `${row.map(plain).join(' & ')} \\\\`);
  return [`\\begin{tabular}{l${'r'.repeat(cells(table)[0].length - 1)}}`, head, '\\hline', ...rows, '\\end{tabular}'].join('\n');
}

/** Buttons that copy a table. */
function tableButtons(table) {
  const button = (name, text) => element('button', {
    type: 'button', class: 'export', 'data-export': name,
    onclick: (event) => { navigator.clipboard?.writeText(text(table)); event.target.textContent = `${name}: copied`; },
  }, name);
  return element('span', { class: 'exports' }, button('Markdown', asMarkdown), button('LaTeX', asLatex));
}
