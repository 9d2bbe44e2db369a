import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFile } from 'node:fs/promises';
import { run, scratchFolder, startViewer } from './viewer.mjs';

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
    const download = viewer.page.waitForEvent('download');
    await viewer.on('paint-save-ply').click();
    await (await download).saveAs(scratch.file('saved.ply'));
    const words = command.split(/\s+/).slice(1);
    words[words.indexOf('paint.ply')] = scratch.file('paint.ply');
    await run(...words, '--quiet');
    const saved = await readFile(scratch.file('saved.ply'));
    const computed = await readFile(scratch.file('paint.ply'));
    assert.equal(saved.length, computed.length);
    const body = (file) => file.subarray(file.indexOf('end_header\n') + 11);
    const [a, b] = [body(saved), body(computed)];
    // x, y, z and the value of each vertex, as doubles.
    let worst = 0;
    for (let at = 0; at < 2562 * 32; at += 8)
      worst = Math.max(worst, Math.abs(a.readDoubleLE(at) - b.readDoubleLE(at)));
    assert.ok(worst < 1e-8, `${worst}`);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});
