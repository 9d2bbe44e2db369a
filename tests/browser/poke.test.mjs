import assert from 'node:assert/strict';
import { test } from 'node:test';
import { farthest, run, savedPoints, scratchFolder, startViewer } from './viewer.mjs';

test('a drag moves the surface in a domain that grows, and vanishes after release', async () => {
  const viewer = await startViewer('shape:icosphere:5');
  try {
    await viewer.tab('poke');
    const vertex = await viewer.visibleVertex();
    const [x, y] = await viewer.see((b, v) => b.screenOf(v), vertex);
    const before = await viewer.see((b, v) => b.positionOf(v), vertex);
    await viewer.page.mouse.move(x, y);
    await viewer.page.mouse.down();
    for (let i = 1; i <= 20; ++i) await viewer.page.mouse.move(x + 2 * i, y - i);
    await viewer.until((b) => b.domainSize().inside > 20);
    const held = await viewer.see((b, v) => b.positionOf(v), vertex);
    assert.ok(Math.hypot(...held.map((p, k) => p - before[k])) > 0.01, 'the vertex follows the pointer');
    assert.ok((await viewer.see((b) => b.lastFrame.force)) !== null);
    const size = await viewer.see((b) => b.domainSize().inside);
    assert.ok(size < 10242, 'only a part of the mesh is solved for');
    await viewer.page.mouse.up();
    await viewer.until((b) => b.domainSize().inside === 0 && b.lastFrame.active === 0);
    const rest = await viewer.see((b, v) => b.positionOf(v), vertex);
    assert.ok(Math.hypot(...rest.map((p, k) => p - before[k])) < 1e-6, 'it is back');
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
  }
});

test('the command line makes the surface that is saved, as it was when the finger let go', async () => {
  const viewer = await startViewer('shape:icosphere:4');
  const scratch = await scratchFolder();
  try {
    await viewer.tab('poke');
    const vertex = await viewer.visibleVertex();
    const [x, y] = await viewer.see((b, v) => b.screenOf(v), vertex);
    await viewer.page.mouse.move(x, y);
    await viewer.page.mouse.down();
    for (let i = 1; i <= 20; ++i) await viewer.page.mouse.move(x + 3 * i, y - 2 * i);
    await viewer.until((b) => b.domainSize().inside > 20);
    for (let i = 20; i <= 30; ++i) await viewer.page.mouse.move(x + 3 * i, y - 2 * i);
    await viewer.page.mouse.up();
    await viewer.until((b) => b.domainSize().inside === 0 && b.lastFrame.active === 0);

    const saved = await savedPoints(await viewer.save('poke-save-ply', 'poke.ply', scratch), 6);
    const path = await viewer.save('poke-save-csv', 'poke.csv', scratch);
    const words = (await viewer.on('poke-command').innerText()).trim().split(/\s+/).slice(1);
    words[words.indexOf('poke.csv')] = path;
    words[words.indexOf('poke.ply')] = scratch.file('computed.ply');
    await run(...words, '--quiet');
    const computed = await savedPoints(scratch.file('computed.ply'), 6);
    const largest = Math.max(...saved.map(([, , , ...u]) => Math.hypot(...u)));
    const error = farthest(saved.flat(), computed.flat());
    assert.ok(largest > 0.05, `${largest}`);
    // Equal but for rounding, unless steps were late: those stop where they are.
    assert.ok(error < 0.01 * largest, `${error} of ${largest}`);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});
