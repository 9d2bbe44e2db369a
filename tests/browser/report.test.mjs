import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFile, writeFile } from 'node:fs/promises';
import { run, scratchFolder, startBrowser } from './viewer.mjs';

const sphere = 'shape:icosphere:3';
/** Every command, in an order in which each finds what it needs. */
const commandsIn = (scratch) => ({
  info: [],
  heat: ['--source', '0=100', '--steps', '5'],
  wave: ['--impulse', '0=1', '--steps', '5'],
  interpolate: ['--fix', '0=0', '--fix', '100=1'],
  vectors: ['--fix', '0=1,0,0', '--fix', '100=0,0,1'],
  poisson: ['--fix', '0=1', '--fix', '100=0'],
  curvature: [],
  fair: ['--box', '-2,-2,0,2,2,2', '--laplacian', '1'],
  membrane: ['--box', '-2,-2,0,2,2,2', '--steps', '5'],
  poke: ['--path', scratch.file('path.csv')],
  harmonics: ['-k', '20', '-o', scratch.file('basis')],
  filter: ['--basis', scratch.file('basis'), '--filter', 'low-pass:2'],
  spectrum: ['--basis', scratch.file('basis'), '--on', 'positions'],
  signature: ['--basis', scratch.file('basis'), '--kind', 'hks', '--times', '0.1,1'],
  nodal: ['--basis', scratch.file('basis'), '--function', '3'],
});

/** Every number of the summary under its path, such as result.fields.u.max.0. */
function numbers(value, path = '', list = []) {
  if (typeof value === 'number') list.push([path.slice(1), value]);
  else if (value !== null && typeof value === 'object')
    for (const [key, item] of Object.entries(value)) numbers(item, `${path}.${key}`, list);
  return list;
}

test('a report opens from disk without a network, with the numbers of the summary', async () => {
  const scratch = await scratchFolder();
  const browser = await startBrowser();
  try {
    await writeFile(scratch.file('path.csv'), '0,0,0,0,0\n0.05,0,0,0,-0.05\n');
    for (const [command, words] of Object.entries(commandsIn(scratch))) {
      const html = scratch.file(`${command}.html`);
      const json = scratch.file(`${command}.json`);
      await run(command, sphere, ...words, '--report', html, '--summary', json, '--quiet');
      const context = await browser.newContext({ offline: true });
      const page = await context.newPage();
      const asked = [];
      const complaints = [];
      page.on('request', (request) => asked.push(request.url()));
      page.on('pageerror', (error) => complaints.push(error.message));
      await page.goto(`file://${html}`);
      const end = Date.now() + 60000;
      while (!(await page.evaluate('window.beltrami?.ready'))) {
        assert.ok(Date.now() < end, `${command}: the report is not drawn`);
        await new Promise((resolve) => setTimeout(resolve, 20));
      }
      const elsewhere = asked.filter(
        (url) => !url.startsWith('file:') && !url.startsWith('blob:') && !url.startsWith('data:'),
      );
      assert.deepEqual(elsewhere, [], command);
      assert.deepEqual(complaints, [], command);
      const shown = new Map(
        await page.evaluate(() =>
          [...document.querySelectorAll('[data-path]')].map((cell) => [cell.dataset.path, cell.textContent]),
        ),
      );
      const expected = numbers(JSON.parse(await readFile(json, 'utf8')));
      assert.ok(expected.length > 20, command);
      for (const [path, value] of expected) assert.equal(Number(shown.get(path)), value, `${command}: ${path}`);
      assert.match(
        await page.locator('[data-test="command"]').innerText(),
        new RegExp(`beltrami ${command} ${sphere}`),
      );
      await context.close();
    }
  } finally {
    await browser.close();
    await scratch.remove();
  }
});
