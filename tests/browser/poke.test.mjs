import assert from 'node:assert/strict';
import { test } from 'node:test';
import { startViewer } from './viewer.mjs';

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
