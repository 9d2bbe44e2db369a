import assert from 'node:assert/strict';
import { test } from 'node:test';
import { startViewer } from './viewer.mjs';

test('fifty harmonics are computed and certified, and the surface follows the filter curve', async () => {
  const viewer = await startViewer('shape:bumpy-sphere:3000');
  try {
    await viewer.tab('harmonics');
    await viewer.fill('harmonics-count', 50);
    await viewer.until((b) => b.state.harmonics.computed === 50);
    assert.match(await viewer.on('harmonics-certificate').innerText(), /complete/);
    await viewer.on('curve-preset-low-pass').click();
    await viewer.until((b) => b.state.harmonics.curve !== null && b.lastFrame?.roughness < 1);
    const before = await viewer.see((b) => b.lastFrame.roughness);
    // The end of the pass band, dragged to lower frequencies.
    const point = viewer.on('curve-point-1');
    await point.scrollIntoViewIfNeeded();
    const box = await point.boundingBox();
    const curve = await viewer.on('curve').boundingBox();
    await viewer.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await viewer.page.mouse.down();
    for (let i = 1; i <= 10; ++i) {
      await viewer.page.mouse.move(box.x + box.width / 2 - (i / 10) * (box.x - curve.x) * 0.7, box.y + box.height / 2);
    }
    await viewer.page.mouse.up();
    await viewer.until((b, was) => b.lastFrame?.roughness < 0.9 * was, before);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
  }
});
