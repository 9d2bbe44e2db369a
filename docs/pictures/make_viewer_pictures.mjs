// Makes the pictures of the viewer in the README and in docs/: ./dev pictures
//
// usage: node make_viewer_pictures.mjs FOLDER
import { join } from 'node:path';
import { bunny, run, scratchFolder, startViewer } from '../../tests/browser/viewer.mjs';

const folder = process.argv[2] ?? '.';

async function picture(name, mesh, act) {
  const viewer = await startViewer(mesh, {
    size: { width: 1280, height: 760 },
  });
  try {
    await act(viewer);
    // A page without a graphics card draws drafts while things move.
    await new Promise((resolve) => setTimeout(resolve, 600));
    await viewer.page.screenshot({ path: join(folder, name) });
    console.log(`${name}: ${mesh}`);
  } finally {
    await viewer.close();
  }
}

/** The vertex that is nearest to a place, in the mesh's coordinates. */
const nearest = (viewer, place) =>
  viewer.see((b, [x, y, z]) => {
    let best = 0;
    let least = Infinity;
    for (let v = 0; v < b.mesh.vertices; ++v) {
      const p = b.positionOf(v);
      const d = (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2;
      if (d < least) [best, least] = [v, d];
    }
    return best;
  }, place);

await picture('viewer_poke.png', bunny, async (viewer) => {
  await viewer.tab('poke');
  const [x, y] = await viewer.see((b, v) => b.screenOf(v), await nearest(viewer, [0.45, -0.35, 0.7]));
  await viewer.page.mouse.move(x, y);
  await viewer.page.mouse.down();
  for (let i = 1; i <= 60; ++i) {
    await viewer.page.mouse.move(x + 1.2 * i, y - 0.6 * i);
    await new Promise((resolve) => setTimeout(resolve, 16));
  }
  await viewer.until((b) => b.domainSize().inside > 100);
  await new Promise((resolve) => setTimeout(resolve, 2500));
});

await picture('viewer_paint.png', bunny, async (viewer) => {
  await viewer.tab('paint');
  const places = [
    [-0.62, 0.42, 0.42, 1],
    [0.45, -0.35, 0.7, 0],
    [-0.35, -0.2, 0.55, 0.5],
    [0.85, -0.6, 0.3, 1],
  ];
  for (const [x, y, z, value] of places) {
    await viewer.fill('paint-vertex', await nearest(viewer, [x, y, z]));
    await viewer.fill('paint-value-number', value);
  }
  await viewer.fill('paint-gamma-2-number', 0.05);
  await viewer.until((b) => b.state.paint.gamma_2 === 0.05);
  await new Promise((resolve) => setTimeout(resolve, 1500));
});

await picture('viewer_harmonics.png', bunny, async (viewer) => {
  await viewer.tab('harmonics');
  await viewer.fill('harmonics-count', 300);
  await viewer.until((b) => b.state.harmonics.computed === 300);
  await viewer.on('curve-preset-exaggerate').click();
  await viewer.until((b) => b.state.harmonics.curve !== null && b.lastFrame?.roughness !== undefined);
  await viewer.on('curve').scrollIntoViewIfNeeded();
});

const scratch = await scratchFolder();
try {
  const heat = scratch.file('heat.ply');
  await run('heat', bunny, '--source', '12736=100', '-o', heat, '--quiet');
  await run(
    'view',
    heat,
    '--screenshot',
    join(folder, 'screenshot.png'),
    '--field',
    'u',
    '--range',
    '0,40',
    '--isolines',
    '--size',
    '900,700',
    '--quiet',
  );
} finally {
  await scratch.remove();
}
