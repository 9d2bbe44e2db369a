import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { test } from 'node:test';

const page = new URL('../../apps/view/page', import.meta.url).pathname;
const { build } = createRequire(join(page, 'package.json'))('esbuild');

async function moduleOf(source) {
  const { outputFiles } = await build({
    entryPoints: [join(page, 'src', source)],
    write: false,
    bundle: true,
    format: 'esm',
  });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString('base64')}`);
}

const { DraftPace } = await moduleOf('scene/draft_size.ts');

/** The sizes on the way, of a machine that draws so many pixels and vertices in a millisecond. */
function sizesOn(pixels, vertices, drafts = 1000) {
  const pace = new DraftPace();
  return Array.from({ length: drafts }, () => {
    const { size } = pace;
    pace.drawn(8 + size.pixels / pixels + size.vertices / vertices);
    return size.pixels;
  });
}

test('drafts are as fine as the machine draws quickly', () => {
  const fast = sizesOn(100_000, 5_000).at(-1);
  const middling = sizesOn(20_000, 800).at(-1);
  const slow = sizesOn(4_000, 200).at(-1);
  assert.ok(slow < middling && middling < fast, `${slow}, ${middling}, ${fast}`);
});

test('their size settles', () => {
  for (let speed = 2_000; speed < 200_000; speed *= 1.05) {
    const sizes = sizesOn(speed, speed / 25);
    const changes = sizes.filter((size, i) => i > 0 && size !== sizes[i - 1]);
    assert.ok(changes.length <= 3, `${speed}: ${changes}`);
  }
});

test('one late draft changes nothing', () => {
  const pace = new DraftPace();
  const { size } = pace;
  for (let i = 0; i < 1000; ++i) pace.drawn(i % 4 === 0 ? 500 : 28);
  assert.deepEqual(pace.size, size);
});

test('a machine that is free again draws finer', () => {
  const pace = new DraftPace();
  for (let i = 0; i < 100; ++i) pace.drawn(100);
  const coarsest = pace.size.pixels;
  for (let i = 0; i < 100; ++i) pace.drawn(12);
  assert.ok(pace.size.pixels > coarsest);
});
