// How long the viewer takes, from what a person does to the picture that shows it, in headless Chromium:
//
//     node tests/browser/latency.mjs [MESH ...]
//
// A picture counts when the browser has drawn it, not when the page has asked for it. CPU is what the program and all of
// Chromium use together. Without a mesh: the bunny, and a sphere of 150 000 vertices.
import { readdirSync, readFileSync } from 'node:fs';
import { loadavg } from 'node:os';
import { bunny, startViewer } from './viewer.mjs';

const clicks = 20;
const hand = 400; // ms that a hand takes from one thing to the next, at least
const dragSeconds = 5;
const pointerRate = 60; // events in a second: a browser gives a page one for each picture

const meshes = process.argv.length > 2 ? process.argv.slice(2) : [bunny, 'shape:bumpy-sphere:150000'];

const sorted = (numbers) => [...numbers].sort((a, b) => a - b);
const median = (numbers) => (numbers.length === 0 ? NaN : sorted(numbers)[Math.floor(numbers.length / 2)]);
const ms = (x) => (Number.isFinite(x) ? `${x.toFixed(0)} ms` : '-');
const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Processor milliseconds of this process's children and theirs so far, by what they are. */
function cpu() {
  const processes = new Map();
  for (const name of readdirSync('/proc')) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const stat = readFileSync(`/proc/${name}/stat`, 'utf8');
      const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
      const line = readFileSync(`/proc/${name}/cmdline`, 'latin1');
      const kind = line.includes('--type=gpu-process')
        ? 'drawing'
        : line.includes('--type=renderer')
          ? 'page'
          : line.includes('chrom')
            ? 'browser'
            : 'program';
      processes.set(Number(name), {
        parent: Number(fields[1]),
        used: 10 * (Number(fields[11]) + Number(fields[12])),
        kind,
      });
    } catch {
      // It has ended.
    }
  }
  const own = (id) => id === process.pid || (processes.has(id) && own(processes.get(id).parent));
  const sum = { program: 0, page: 0, drawing: 0, browser: 0 };
  for (const [id, { used, kind }] of processes) {
    if (id !== process.pid && own(id)) sum[kind] += used;
  }
  return sum;
}

function since(before) {
  const now = cpu();
  return Object.fromEntries(Object.keys(now).map((kind) => [kind, now[kind] - before[kind]]));
}

/** What the page measured of `what` while `act` ran; CPU milliseconds in that time. */
async function measured(viewer, what, act) {
  const last = (await viewer.see((b) => b.latencies())).at(-1)?.id ?? 0;
  const shown = await viewer.see((b) => b.framesShown);
  const before = cpu();
  const start = performance.now();
  await act();
  const seconds = (performance.now() - start) / 1e3;
  const used = since(before);
  const pictures = (await viewer.see((b) => b.framesShown)) - shown;
  await pause(300);
  const all = (await viewer.see((b) => b.latencies())).filter((l) => l.do === what && l.id > last);
  return {
    all,
    seconds,
    used,
    pictures,
    times: all.map((l) => l.painted - l.sent),
  };
}

function rowOf({ all, seconds, used, times, pictures }) {
  const each = Object.entries(used).map(([kind, x]) => `${kind} ${(x / Math.max(pictures, 1)).toFixed(0)}`);
  return [
    `${(pictures / seconds).toFixed(1)} a second`,
    `median ${ms(median(times))}, worst ${ms(Math.max(...times))}`,
    `until the frame came ${ms(median(all.map((l) => l.received - l.sent)))}; CPU ms each: ${each.join(', ')}`,
  ];
}

/** The pointer moves for a while, as fast as a mouse tells it, through places(0 .. 1). A mouse does not wait for the page. */
async function drag(page, places) {
  await page.mouse.move(...places(0));
  await page.mouse.down();
  const start = performance.now();
  const moves = [];
  for (let now = start; now < start + 1e3 * dragSeconds; now = performance.now()) {
    moves.push(page.mouse.move(...places((now - start) / 1e3 / dragSeconds)));
    await pause(1e3 / pointerRate);
  }
  await Promise.all(moves);
}

async function clickAround(viewer) {
  const vertices = [];
  for (let k = 0; k < clicks + 1; ++k) vertices.push(await viewer.visibleVertex(40 * k));
  const { all } = await measured(viewer, 'paint.fix', async () => {
    for (const vertex of vertices) {
      const before = await viewer.see((b) => b.latencies().length);
      await viewer.clickVertex(vertex);
      await viewer.until((b, n) => b.latencies().length > n, before);
      await pause(hand);
    }
  });
  const [first, ...others] = all.map((l) => l.painted - l.sent);
  const answers = all.slice(1).map((l) => l.received - l.sent);
  return [
    `first ${ms(first)}`,
    `then median ${ms(median(others))}, worst ${ms(Math.max(...others))}`,
    `of which until the frame came: ${ms(median(answers))}`,
  ];
}

async function measure(mesh) {
  const note = (what, ...values) => {
    console.log(
      `  ${what.padEnd(34)} ${values.map((value) => value.padEnd(28)).join(' ')}  load ${loadavg()[0].toFixed(1)}`,
    );
  };
  const start = performance.now();
  const viewer = await startViewer(mesh);
  try {
    const { page } = viewer;
    const [vertices, renderer] = await viewer.see((b) => [b.mesh.vertices, b.renderer.name]);
    console.log(`${mesh}: ${vertices} vertices, ${renderer}`);
    note('load, with program and browser', ms(performance.now() - start));

    await viewer.tab('paint');
    await pause(1000);
    note('click, Laplacian', ...(await clickAround(viewer)));
    await viewer.on('paint-clear').click();
    await viewer.until((b) => b.state.paint.fixed.length === 0);
    await viewer.fill('paint-gamma-2-number', await viewer.see((b) => (30 * b.mesh.mean_edge) ** 2));
    await viewer.until((b) => b.state.paint.gamma_2 > 0);
    await pause(hand);
    note('click, with bi-Laplacian', ...(await clickAround(viewer)));

    await viewer.tab('poke');
    const [x, y] = await viewer.see((b, v) => b.screenOf(v), await viewer.visibleVertex(200));
    const circle = (t) => [x + 40 * Math.sin(9 * t), y + 40 * (1 - Math.cos(9 * t))];
    note('poke', ...rowOf(await measured(viewer, 'poke.hold', () => drag(page, circle))));
    await page.mouse.up();
    await viewer.until((b) => b.lastFrame.active === 0);

    await viewer.tab('harmonics');
    for (const count of [50, 300]) {
      const computing = performance.now();
      await viewer.fill('harmonics-count', count);
      await viewer.until((b, n) => b.state.harmonics.computed === n && b.state.running === null, count);
      note(`${count} harmonics, computed in`, ms(performance.now() - computing));
      await viewer.on('curve-preset-low-pass').click();
      await viewer.until((b) => b.lastFrame?.roughness !== undefined);
      await pause(500);
      const point = viewer.on('curve-point-1');
      await point.scrollIntoViewIfNeeded();
      const box = await point.boundingBox();
      const chart = await viewer.on('curve').boundingBox();
      const left = Math.min(120, 0.7 * (box.x - chart.x));
      const place = (t) => [box.x + box.width / 2 - left * Math.abs(Math.sin(5 * t)), box.y + box.height / 2 + 20 * t];
      note(`filter by ${count}`, ...rowOf(await measured(viewer, 'harmonics.filter', () => drag(page, place))));
      await page.mouse.up();
    }
    if (viewer.complaints.length > 0) console.log(`  the page complained: ${viewer.complaints.join('; ')}`);
  } finally {
    await viewer.close();
  }
}

for (const mesh of meshes) await measure(mesh);
