// Builds the page and writes it as C++ source: node scripts/build.mjs FOLDER [FILE.cpp]
import {execFileSync} from 'node:child_process';
import {existsSync, readFileSync, writeFileSync} from 'node:fs';
import {resolve} from 'node:path';
import {fileURLToPath} from 'node:url';

const viewer = fileURLToPath(new URL('..', import.meta.url));
const folder = resolve(process.argv[2]);
const source = process.argv[3];

if (!existsSync(resolve(viewer, 'node_modules'))) {
  execFileSync('npm', ['ci', '--no-audit', '--no-fund', '--loglevel=error'], {cwd: viewer, stdio: 'inherit'});
}
process.env.NODE_ENV = 'production';
const {build} = await import('vite');
await build({root: viewer, logLevel: 'warn', build: {outDir: folder, emptyOutDir: true}});

const page = readFileSync(resolve(folder, 'index.html'));
for (const mark of ['@TREMULA_TITLE@', '@TREMULA_LOOP@']) {
  if (page.toString().split(mark).length !== 2) throw new Error(`the page must hold ${mark} once`);
}
if (/\b(src|href)="(?!data:)/.test(page.toString().replace(/<script[^]*?<\/script>/g, ''))) {
  throw new Error('the page refers to another file');
}

// A string literal, in lines; three octal digits cannot run into what follows.
function literal(bytes) {
  let text = '';
  for (const byte of bytes) {
    const char = String.fromCharCode(byte);
    if (char === '\n') text += '\\n';
    else if (char === '"' || char === '\\' || char === '?') text += '\\' + char;
    else if (byte < 32 || byte > 126) text += '\\' + byte.toString(8).padStart(3, '0');
    else text += char;
  }
  return `    "${text}"\n`;
}

if (source) {
  let cpp = '// Written by viewer/scripts/build.mjs.\n#include <string_view>\n\nnamespace tremula {\n\n' +
      'std::string_view viewer_page();\nstd::string_view viewer_page() {\n  static constexpr char page[] =\n';
  for (let i = 0; i < page.length; i += 100) cpp += literal(page.subarray(i, i + 100));
  cpp += '      ;\n  return {page, sizeof page - 1};\n}\n\n}  // namespace tremula\n';
  writeFileSync(source, cpp);
}
