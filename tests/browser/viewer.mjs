// The viewer as a person has it: the program beltrami view, and headless Chromium on its page.
//
//     const viewer = await startViewer('shape:icosphere:4');
//     await viewer.tab('heat');
//     await viewer.clickVertex(7);
//     await viewer.close();
//
// BELTRAMI_PROGRAM is the program, if not that of the release build; BELTRAMI_PAGE a page that node build.mjs has made, in
// place of the one in the program.
import { execFile, spawn } from 'node:child_process';
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { promisify } from 'node:util';

const project = new URL('../..', import.meta.url).pathname;
const { chromium } = createRequire(join(project, 'apps/view/page/package.json'))('playwright-core');
export const program = process.env.BELTRAMI_PROGRAM ?? join(project, 'build/release/apps/beltrami');
export const bunny = '/usr/share/glmark2/models/bunny.obj';
/** Of one wait; the machine may be busy with other tests. */
export const patience = 60000;

export async function run(...args) {
  return promisify(execFile)(program, args, { maxBuffer: 1 << 28 });
}

export async function scratchFolder() {
  const path = await mkdtemp(join(tmpdir(), 'beltrami-browser-'));
  return {
    path,
    file: (name) => join(path, name),
    remove: () => rm(path, { recursive: true, force: true }),
  };
}

/** Of a PLY file of the program's the vertices, each with so many numbers. */
export async function savedPoints(path, columns) {
  const file = await readFile(path);
  const header = file.subarray(0, file.indexOf('end_header\n')).toString();
  const vertices = Number(header.match(/element vertex (\d+)/)[1]);
  const start = header.length + 'end_header\n'.length;
  return Array.from({ length: vertices }, (_, v) =>
    Array.from({ length: columns }, (_, k) => file.readDoubleLE(start + 8 * (columns * v + k))),
  );
}

/** The largest difference of two lists of numbers. */
export function farthest(a, b) {
  return a.reduce((worst, x, i) => Math.max(worst, Math.abs(x - b[i])), 0);
}

export async function startBrowser() {
  return chromium.launch({
    executablePath: process.env.BELTRAMI_BROWSER ?? '/usr/bin/chromium',
    args: [
      '--headless',
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });
}

/** `beltrami view` alone: { url, log, stop() }. */
export async function startProgram(...args) {
  const child = spawn(program, ['view', ...args, '--no-open']);
  let out = '';
  let log = '';
  child.stderr.on('data', (data) => (log += data));
  const ended = new Promise((resolve) => child.on('exit', (status) => resolve(status)));
  const url = await new Promise((resolve, reject) => {
    child.stdout.on('data', (data) => {
      out += data;
      const found = out.match(/http:\S+/);
      if (found) resolve(found[0]);
    });
    ended.then((status) => reject(new Error(`beltrami view ended with ${status}: ${log}`)));
  });
  return {
    url,
    pid: child.pid,
    log: () => log,
    running: () => child.exitCode === null,
    stop: async () => {
      child.kill('SIGINT');
      return ended;
    },
  };
}

export async function startViewer(mesh, { size = { width: 1280, height: 800 }, args = [] } = {}) {
  const server = await startProgram(mesh, ...args);
  const browser = await startBrowser();
  const context = await browser.newContext({
    viewport: size,
    acceptDownloads: true,
  });
  // Of a page that it did not fetch itself the browser does not know that it is from this machine.
  if (process.env.BELTRAMI_PAGE) await context.grantPermissions(['local-network-access']);
  const page = await context.newPage();
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  page.setDefaultTimeout(patience);

  const viewer = {
    page,
    browser,
    server,
    complaints,
    async ready() {
      await viewer.until((b) => b?.ready);
    },
    /** The value of an expression on window.beltrami, such as see((b) => b.state.task). */
    see(read, argument) {
      return page.evaluate(`(${read})(window.beltrami, ${JSON.stringify(argument) ?? 'undefined'})`);
    },
    /** Waits until an expression on window.beltrami is true. */
    async until(read, argument) {
      // Not waitForFunction, whose polling evaluates a string in the page, which its security policy forbids.
      const end = Date.now() + patience;
      while (!(await viewer.see(read, argument))) {
        if (Date.now() > end) throw new Error(`never true: ${read}`);
        await new Promise((resolve) => setTimeout(resolve, 20));
      }
    },
    on: (test) => page.locator(`[data-test="${test}"]`),
    async tab(task) {
      await page.locator(`[data-test="tab-${task}"]`).click();
      await viewer.until((b, wanted) => b.state?.task === wanted, task);
    },
    async fill(test, text) {
      const box = page.locator(`[data-test="${test}"]`);
      await box.fill(String(text));
      await box.press('Enter');
    },
    /** A vertex that nothing hides, the `skip`-th from the middle of the picture outwards. */
    async visibleVertex(skip = 0) {
      return viewer.see((b, n) => {
        const canvas = document.querySelector('.stage canvas').getBoundingClientRect();
        const seen = new Set();
        for (let ring = 0; ring < 40; ++ring) {
          for (let k = 0; k < Math.max(1, 6 * ring); ++k) {
            const angle = (2 * Math.PI * k) / Math.max(1, 6 * ring);
            const hit = b.hitAt(
              canvas.x + canvas.width / 2 + 12 * ring * Math.cos(angle),
              canvas.y + canvas.height / 2 + 12 * ring * Math.sin(angle),
            );
            if (!hit || !b.visible(hit.vertex)) continue;
            seen.add(hit.vertex);
            if (seen.size > n) return hit.vertex;
          }
        }
        throw new Error('no such vertex is visible');
      }, skip);
    },
    /** Presses a button that saves: where the file is, which must have this name. */
    async save(test, name, scratch) {
      const download = page.waitForEvent('download');
      await viewer.on(test).click();
      const file = await download;
      if (file.suggestedFilename() !== name) throw new Error(`saved ${file.suggestedFilename()}, not ${name}`);
      await file.saveAs(scratch.file(name));
      return scratch.file(name);
    },
    async clickVertex(vertex) {
      const [x, y] = await viewer.see((b, v) => b.screenOf(v), vertex);
      await page.mouse.click(x, y);
    },
    async close() {
      await browser.close();
      const status = await server.stop();
      if (status !== 0) throw new Error(`beltrami view ended with ${status}: ${server.log()}`);
    },
  };
  if (process.env.BELTRAMI_PAGE) {
    const body = await readFile(process.env.BELTRAMI_PAGE);
    await page.route(server.url, (route) => route.fulfill({ contentType: 'text/html; charset=utf-8', body }));
  }
  await page.goto(server.url);
  await viewer.ready();
  return viewer;
}
