import assert from 'node:assert/strict';
import { test } from 'node:test';
import { farthest, run, savedPoints, scratchFolder, startViewer } from './viewer.mjs';

test('a source that is clicked on the surface is the maximum of the field', async () => {
  const viewer = await startViewer('shape:icosphere:4');
  try {
    await viewer.tab('heat');
    const vertex = await viewer.visibleVertex();
    await viewer.clickVertex(vertex);
    await viewer.until((b) => b.state.heat.sources.length === 1);
    assert.deepEqual(await viewer.see((b) => b.state.heat.sources), [[vertex, 100]]);
    await viewer.fill('heat-steps', 20);
    await viewer.until((b) => b.state.heat.steps === 20);
    await viewer.on('heat-run').click();
    await viewer.until((b) => b.lastFrame?.step === 20 && b.timeline.count === 21 && b.timeline.index === 20);
    const values = await viewer.see((b) => Array.from({ length: b.mesh.vertices }, (_, v) => b.valueAt(v)[0]));
    assert.equal(values.indexOf(Math.max(...values)), vertex);
    assert.equal(values[vertex], 100);
    assert.ok(Math.min(...values) > 0, 'heat has reached every vertex');
    assert.match(await viewer.on('heat-command').innerText(), new RegExp(`--source ${vertex}=100 .*--steps 20`));
    // Scrubbing shows an earlier moment, which is colder.
    await viewer.page
      .locator('canvas')
      .first()
      .focus()
      .catch(() => {});
    await viewer.page.keyboard.press('ArrowLeft');
    await viewer.until((b) => b.timeline.index === 19);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
  }
});

test('what is saved is the moment on the screen', async () => {
  const viewer = await startViewer('shape:icosphere:4');
  const scratch = await scratchFolder();
  try {
    await viewer.tab('heat');
    await viewer.clickVertex(await viewer.visibleVertex());
    await viewer.until((b) => b.state.heat.sources.length === 1);
    await viewer.fill('heat-steps', 20);
    await viewer.until((b) => b.state.heat.steps === 20);
    await viewer.on('heat-run').click();
    await viewer.until((b) => b.lastFrame?.step === 20 && b.timeline.index === 20);
    // u behind x, y and z.
    const saved = async (name) =>
      (await savedPoints(await viewer.save('heat-save-ply', name, scratch), 4)).map((point) => point[3]);
    const shown = () => viewer.see((b) => Array.from({ length: b.mesh.vertices }, (_, v) => b.valueAt(v)[0]));

    const last = await saved('heat.ply');
    assert.ok(farthest(last, await shown()) < 1e-5);
    for (let back = 0; back < 13; ++back) await viewer.page.keyboard.press('ArrowLeft');
    await viewer.until((b) => b.timeline.index === 7);
    const earlier = await saved('heat-7.ply');
    assert.ok(farthest(earlier, last) > 0.1, 'it is not the last one');
    assert.equal(farthest(earlier, await shown()), 0, 'it is the one that is shown');

    const words = (await viewer.on('heat-command').innerText()).trim().split(/\s+/).slice(1);
    assert.equal(words.at(-1), 'heat.ply');
    words[words.length - 1] = scratch.file('computed.ply');
    await run(...words, '--quiet');
    const computed = await savedPoints(scratch.file('computed.ply'), 4);
    const error = farthest(
      last,
      computed.map((point) => point[3]),
    );
    assert.ok(error < 1e-7, `the command line makes what heat.ply was: ${error}`);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});

test('a long simulation is cancelled, and a page that is loaded again finds what was done', async () => {
  const viewer = await startViewer('shape:icosphere:5');
  try {
    await viewer.tab('wave');
    const vertex = await viewer.visibleVertex();
    await viewer.clickVertex(vertex);
    await viewer.until((b) => b.state.wave.impulses.length === 1);
    await viewer.fill('wave-steps', 10000);
    await viewer.until((b) => b.state.wave.steps === 10000);
    await viewer.on('wave-run').click();
    await viewer.until((b) => b.state.running?.task === 'wave' && b.lastFrame?.step >= 5);
    await viewer.on('wave-cancel').click();
    await viewer.until((b) => b.state.running === null);
    const reached = await viewer.see((b) => b.lastFrame.step);
    assert.ok(reached < 10000);
    await viewer.page.reload();
    await viewer.ready();
    await viewer.until(
      (b, step) => b.state.task === 'wave' && b.timeline.count >= 5 && b.lastFrame?.step >= step - 1,
      reached,
    );
    assert.deepEqual(await viewer.see((b) => b.state.wave.impulses), [[vertex, 1]]);
    assert.equal(await viewer.on('wave-steps').inputValue(), '10000');
    assert.equal(await viewer.see((b) => b.markers().length), 1);
  } finally {
    await viewer.close();
  }
});
