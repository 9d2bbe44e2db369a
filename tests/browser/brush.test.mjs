import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { test } from 'node:test';
import { scratchFolder, startViewer } from './viewer.mjs';

const side = 21; // vertices
const gap = 0.03;

/** A square of side 1 before another one, as OBJ: vertices 0 .. side^2 - 1 are the one in front. */
function sheets() {
  const lines = [];
  for (const z of [gap, 0])
    for (let v = 0; v < side * side; ++v)
      lines.push(`v ${(v % side) / (side - 1)} ${Math.floor(v / side) / (side - 1)} ${z}`);
  for (const first of [1, 1 + side * side])
    for (let y = 0; y + 1 < side; ++y)
      for (let x = 0; x + 1 < side; ++x) {
        const v = first + x + y * side;
        lines.push(`f ${v} ${v + 1} ${v + side + 1}`, `f ${v} ${v + side + 1} ${v + side}`);
      }
  return `${lines.join('\n')}\n`;
}

/** Drags over the sheet in front, along a row of its vertices: where the surface was touched. */
async function stroke(viewer, from, to) {
  const ends = [];
  for (const vertex of [from, to]) ends.push(await viewer.see((b, v) => b.screenOf(v), vertex));
  const [[x0, y0], [x1, y1]] = ends;
  await viewer.page.mouse.move(x0, y0);
  await viewer.page.mouse.down();
  const way = [];
  for (let i = 0; i <= 10; ++i) {
    const [x, y] = [x0 + ((x1 - x0) * i) / 10, y0 + ((y1 - y0) * i) / 10];
    await viewer.page.mouse.move(x, y);
    way.push((await viewer.see((b, at) => b.hitAt(...at), [x, y])).rest);
  }
  await viewer.page.mouse.up();
  return way;
}

const at = (v) => [(v % side) / (side - 1), (Math.floor(v / side) % side) / (side - 1)];
const near = (way, v) => Math.min(...way.map(([x, y]) => Math.hypot(x - at(v)[0], y - at(v)[1])));

test('a brush wider than the gap between two sheets touches the one that the pointer is on', async () => {
  const scratch = await scratchFolder();
  await writeFile(scratch.file('sheets.obj'), sheets());
  const viewer = await startViewer(scratch.file('sheets.obj'));
  try {
    await viewer.tab('paint');
    const [from, to] = [5 + 10 * side, 15 + 10 * side];
    // One behind is fixed by its number, below the way of the brush.
    const behind = side * side + from;
    await viewer.fill('paint-vertex', behind);
    await viewer.until((b) => b.state.paint.fixed.length === 1);

    await viewer.on('paint-tool-brush').check();
    await viewer.fill('paint-radius-number', 0.12);
    const way = await stroke(viewer, from, to);
    assert.ok(way.every(([, , z]) => Math.abs(z - gap) < 1e-6));
    const fixed = async () => new Set(await viewer.see((b) => b.state.paint.fixed.map(([v]) => v)));
    const expected = [];
    for (let v = 0; v < side * side; ++v) if (near(way, v) < 0.11) expected.push(v);
    assert.ok(expected.length > 60);
    await viewer.until((b, n) => b.state.paint.fixed.length > n, expected.length);
    const painted = await fixed();
    assert.ok(
      expected.every((v) => painted.has(v)),
      'all that is near, in front',
    );
    assert.deepEqual(
      [...painted].filter((v) => v >= side * side),
      [behind],
      'nothing behind',
    );
    assert.ok(
      [...painted].every((v) => v === behind || near(way, v) < 0.13),
      'nothing that is far',
    );

    // What erases reaches no further.
    await viewer.on('paint-tool-erase').check();
    await viewer.fill('paint-radius-number', 0.2);
    await stroke(viewer, from, to);
    await viewer.until((b) => b.state.paint.fixed.length === 1);
    assert.deepEqual([...(await fixed())], [behind]);
    assert.deepEqual(viewer.complaints, []);
  } finally {
    await viewer.close();
    await scratch.remove();
  }
});

test('a brush on a line goes along it', async () => {
  const viewer = await startViewer('shape:circle:200');
  try {
    await viewer.tab('paint');
    await viewer.on('paint-tool-brush').check();
    await viewer.fill('paint-radius-number', 0.11);
    // Chords of 2 sin(0.01 pi k), of which three are shorter than that.
    await viewer.clickVertex(50);
    await viewer.until((b) => b.state.paint.fixed.length > 0);
    const fixed = await viewer.see((b) => b.state.paint.fixed.map(([v]) => v).sort((a, b) => a - b));
    const middle = fixed[3];
    assert.deepEqual(
      fixed,
      [-3, -2, -1, 0, 1, 2, 3].map((k) => middle + k),
    );
    assert.ok(Math.abs(middle - 50) <= 1);
  } finally {
    await viewer.close();
  }
});
