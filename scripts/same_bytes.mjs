// What is the same to the byte, and what only to rounding: runs the main commands with several programs, thread
// counts and vector units and prints the table of docs/theory/numerics.md.
//
//   node scripts/same_bytes.mjs PROGRAM [NAME=PROGRAM ...]
//   node scripts/same_bytes.mjs build/developer/bin/tremula clang=build/clang/bin/tremula kissfft=build/kissfft/bin/tremula
//
// The first program with two threads is what everything is held against. Beside the others it runs with one
// thread, and as on a machine without AVX2 and FMA (the C library then takes other versions of its functions).
// A number in the table is the largest difference over the largest magnitude in the same column of the file.
// Exit 1 where another number of threads changes a byte.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

const [program, ...others] = process.argv.slice(2);
if (!program) {
  console.error('usage: same_bytes.mjs PROGRAM [NAME=PROGRAM ...]');
  process.exit(2);
}

// Each reads what it needs from the first program's plant, so that a row tells of its own stage alone.
const rows = [
  { what: 'grown plant (.swc)', file: 'grown.swc', args: ['grow', 'oak', '-o'], serial: true },
  { what: 'modes (.csv)', file: 'modes.csv', args: ['modes', 'plant.swc', '--modes', '20', '--format', 'csv', '-o'],
    columns: 2 },
  { what: 'poses, turbulent wind (.csv)', file: 'turbulent.csv', args: ['animate', 'plant.swc', '--period', '10', '-o'] },
  { what: "poses, Stam's wind (.csv)", file: 'stam.csv',
    args: ['animate', 'plant.swc', '--wind', 'stam', '--period', '10', '-o'] },
  { what: 'animation (.glb)', file: 'loop.glb', args: ['animate', 'plant.swc', '--period', '10', '-o'] },
  { what: 'wind field (.bts)', file: 'field.bts', args: ['wind', '--points', '15x15', '--steps', '1024', '-o'] },
];

const work = mkdtempSync(join(tmpdir(), 'tremula-bytes-'));
const run = (which, args, environment = {}) =>
  execFileSync(resolve(which), args, { cwd: work, stdio: 'ignore', env: { ...process.env, ...environment } });
run(program, ['grow', 'sapling', '-o', 'plant.swc']);

function output(row, which, threads, environment) {
  const path = join(work, row.file);
  run(which, [...row.args, path, ...(row.serial ? [] : ['--threads', String(threads)])], environment);
  const bytes = readFileSync(path);
  rmSync(path);
  return bytes;
}

const table = (bytes, columns) => bytes.toString('latin1').split('\n').filter((line) => /^\s*-?\d/.test(line))
  .map((line) => line.trim().split(/[\s,]+/).slice(0, columns).map(Number));

function difference(row, a, b) {
  if (a.equals(b)) return 'same bytes';
  if (/\.(glb|bts)$/.test(row.file)) {
    if (a.length !== b.length) return `${a.length} and ${b.length} bytes`;
    let count = 0;
    for (let i = 0; i < a.length; ++i) count += a[i] !== b[i];
    return `${(100 * count / a.length).toPrecision(2)} % of the bytes`;
  }
  const x = table(a, row.columns), y = table(b, row.columns);
  if (x.length !== y.length) return `${x.length} and ${y.length} lines`;
  const scale = [], apart = [];
  x.forEach((line, i) => line.forEach((value, k) => {
    if (!Number.isFinite(value)) return;
    scale[k] = Math.max(scale[k] ?? 0, Math.abs(value));
    apart[k] = Math.max(apart[k] ?? 0, Math.abs(value - y[i][k]));
  }));
  const worst = Math.max(...apart.map((d, k) => (d > 0 ? d / scale[k] : 0)));
  return worst > 0 ? worst.toExponential(0) : 'same numbers';
}

const comparisons = [
  { name: 'one thread', program, threads: 1 },
  { name: 'without AVX2, FMA', program, threads: 2,
    environment: { GLIBC_TUNABLES: 'glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F' } },
  ...others.map((word) => {
    const [name, path] = word.split('=');
    return { name, program: path, threads: 2 };
  })];

console.log(`| | ${comparisons.map(({ name }) => name).join(' | ')} |`);
console.log(`|---|${'---|'.repeat(comparisons.length)}`);
let threadsMatter = false;
for (const row of rows) {
  const first = output(row, program, 2);
  const cells = comparisons.map((other) => difference(row, first, output(row, other.program, other.threads, other.environment)));
  threadsMatter ||= cells[0] !== 'same bytes';
  console.log(`| ${row.what} | ${cells.join(' | ')} |`);
}
rmSync(work, { recursive: true, force: true });
process.exit(threadsMatter ? 1 : 0);
