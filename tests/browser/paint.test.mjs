import assert from 'node:assert/strict';
import { test } from 'node:test';
import { farthest, run, savedPoints, scratchFolder, startViewer } from './viewer.mjs';

test('between two painted values the field takes values between, and saves what the command line computes', async () => {
  const viewer = await startViewer('shape:icosphere:4');
  const scratch = await scratchFolder();
  try {
    await viewer.tab('paint');
    const first = await viewer.visibleVertex(0);
    const second = await viewer.visibleVertex(300);
    await viewer.clickVertex(first);
    await viewer.until((b) => b.state.paint.fixed.length === 1);
    await viewer.clickVertex(second);
    await viewer.until((b) => b.state.paint.fixed.length === 2);
    // The slider is now that of the second one.
    await viewer.fill('paint-value-number', 3);
    await viewer.until(
      (b, [p, q]) => Math.abs(b.valueAt(p)?.[0] - 1) < 1e-6 && Math.abs(b.valueAt(q)?.[0] - 3) < 1e-6,
      [first, second],
    );
    const between = await viewer.visibleVertex(100);
    const value = (await viewer.see((b, v) => b.valueAt(v), between))[0];
    assert.ok(value > 1 && value < 3, `${value}`);

    const command = (await viewer.on('paint-command').innerText()).trim();
    const saved = await savedPoints(await viewer.save('paint-save-ply', 'paint.ply', scratch), 4);
    const words = command.split(/\s+/).slice(1);
    words[words.indexOf('paint.ply')] = scratch.file('computed.ply');
    await run(...words, '--quiet');
    const computed = await savedPoints(scratch.file('computed.ply'), 4);
    assert.equal(saved.length, computed.length);
    // x, y, z and the value.
    const worst = farthest(saved.flat(), computed.flat());
    assert.ok(worst < 1e-8, `${worst}`);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});
