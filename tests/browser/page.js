// A page in a real browser, and all that it says and asks for.

import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

/** Opens the report in a folder. `said`: errors and warnings; `asked`: what it loaded; `test` runs a check and counts it. */
export async function open(folder, shots) {
  mkdirSync(shots, { recursive: true });
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: ['--no-sandbox'] });
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  const said = [];
  const asked = [];
  // It is this test that reads pixels back, and is told so.
  const isOurs = (message) => message.text().includes('willReadFrequently');
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && !isOurs(message) && said.push(message.text()));
  page.on('pageerror', (error) => said.push(error.message));
  page.on('request', (request) => asked.push(request.url()));
  await page.goto(`file://${join(folder, 'index.html')}`);
  await page.waitForFunction(() => [...document.querySelectorAll('article')].every((part) => part.dataset.shown !== undefined));
  let done = 0;
  const test = async (name, check) => {
    await check();
    done += 1;
    console.log(`ok ${done} ${name}`);
  };
  const close = async () => {
    await browser.close();
    console.log(`${done} tests passed; screenshots in ${shots}`);
  };
  return { page, said, asked, test, close };
}

/** A number that changes when any pixel of a pane of a sensor's part does. */
export const pixels = (page, pane, part = 0) => page.evaluate(([kind, at]) => {
  const canvas = document.querySelectorAll('article')[at].querySelector(`[data-pane=${kind}] canvas`);
  const bytes = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  return bytes.reduce((hash, byte) => (Math.imul(hash, 31) + byte) | 0, 7);
}, [pane, part]);
