// Makes the page: `node build.mjs OUT.html` writes one HTML file that needs no other.
//
// The script is inline, so the Content-Security-Policy names it by its hash, which is taken here. The marker
// <!--beltrami:data--> is left in the file: that is where the program puts the data of a report.
import { build } from 'esbuild';
import { createHash } from 'node:crypto';
import { readFile, rename, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (!out) {
  console.error('usage: node build.mjs OUT.html');
  process.exit(2);
}

const bundle = await build({
  entryPoints: [join(here, 'src/main.ts')],
  outdir: join(here, 'never-written'),
  write: false,
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  legalComments: 'none',
  logLevel: 'warning',
});
const textOf = (ending) => bundle.outputFiles.find((file) => file.path.endsWith(ending))?.text.trim() ?? '';
const script = textOf('.js');
const style = textOf('.css');

// Either would end the inline element early.
const demand = (holds, what) => {
  if (!holds) throw new Error(`build.mjs: ${what}`);
};
demand(script !== '' && style !== '', 'the bundle is empty');
demand(!/<\/script|<!--|\r/i.test(script), 'the script holds </script, <!-- or a carriage return');
demand(!/<\/style|\r/i.test(style), 'the style holds </style or a carriage return');

const policy = [
  "default-src 'none'",
  `script-src 'sha256-${createHash('sha256').update(script, 'utf8').digest('base64')}'`,
  "style-src 'unsafe-inline'",
  'img-src data: blob:',
  "connect-src 'self'",
  "base-uri 'none'",
  "form-action 'none'",
].join('; ');

let html = await readFile(join(here, 'index.html'), 'utf8');
const put = (place, text) => {
  demand(place.test(html), `index.html must hold ${place}`);
  html = html.replace(place, () => text);
};
put(/POLICY/, policy);
put(/<style>\s*<\/style>/, `<style>${style}</style>`);
put(/<script>\s*<\/script>/, `<script>${script}</script>`);
demand(html.split('<!--beltrami:data-->').length === 2, 'the data marker must be there once');

await writeFile(`${out}.part`, html);
await rename(`${out}.part`, out);
