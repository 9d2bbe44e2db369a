import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFile } from 'node:fs/promises';
import { bunny, run, scratchFolder, startBrowser, startProgram, startViewer } from './viewer.mjs';

test('a mesh is shown with its report, its edges and its fields, and the page remembers how it was looked at', async () => {
  const scratch = await scratchFolder();
  await run('curvature', 'shape:grid:30x30', '-o', scratch.file('grid.ply'), '--quiet');
  const viewer = await startViewer(scratch.file('grid.ply'));
  try {
    assert.equal(await viewer.see((b) => b.mesh.vertices), 961);
    assert.match(await viewer.on('mesh-brief').innerText(), /961 vertices.*boundary/);
    await viewer
      .on('look-field')
      .selectOption({ label: 'mean_curvature' })
      .catch(() => viewer.on('look-field').selectOption('mean_curvature'));
    await viewer.until((b) => b.shown.kind === 'scalar' && b.shown.name === 'mean_curvature');
    const vertex = await viewer.visibleVertex();
    assert.equal((await viewer.see((b, v) => b.valueAt(v), vertex)).length, 1);
    await viewer.page.keyboard.press('w');
    await viewer.until((b) => b.display.wireframe);
    await viewer.page.reload();
    await viewer.ready();
    await viewer.until((b) => b.display.wireframe);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});

test('a picture is drawn without a person', async () => {
  const scratch = await scratchFolder();
  try {
    const picture = scratch.file('bunny.png');
    await run('view', bunny, '--screenshot', picture, '--camera', 'iso', '--size', '400,300', '--quiet');
    const png = await readFile(picture);
    assert.equal(png.readUInt32BE(16), 400);
    assert.equal(png.readUInt32BE(20), 300);
    assert.ok(png.length > 10000, 'it is not blank');
    await assert.rejects(run('view', bunny, '--screenshot', picture, '--camera', 'sideways'), (error) => {
      assert.equal(error.code, 2);
      assert.match(error.stderr, /there is no view 'sideways'/);
      return true;
    });
  } finally {
    await scratch.remove();
  }
});

test('a page of another origin is not let in', async () => {
  const server = await startProgram('shape:icosphere:2');
  const other = await startProgram('shape:icosphere:2');
  const browser = await startBrowser();
  try {
    const page = await browser.newPage();
    await page.goto(new URL('/', other.url).href); // 403, but an origin of its own
    const outcome = await page.evaluate(
      (url) =>
        new Promise((resolve) => {
          const socket = new WebSocket(url.replace('http', 'ws') + 'socket');
          socket.onopen = () => resolve('open');
          socket.onerror = () => resolve('refused');
        }),
      server.url,
    );
    assert.equal(outcome, 'refused');
    assert.equal(
      await page.evaluate(
        (url) =>
          fetch(url).then(
            () => 'read',
            () => 'refused',
          ),
        server.url,
      ),
      'refused',
    );
    assert.match(server.log(), /Origin/);
    assert.ok(server.running());
    const wrong = await page.goto(server.url.replace(/[0-9a-f]{32}/, '0'.repeat(32)));
    assert.equal(wrong.status(), 403);
  } finally {
    await browser.close();
    await server.stop();
    await other.stop();
  }
});
