// Runs every tremula command that README, docs/guide and the help texts show, and compares what it prints with
// what stands below it.
//
//   node scripts/run_docs.mjs BUILD [DOCUMENT ...]       says where they differ; exit 1
//   node scripts/run_docs.mjs --refresh BUILD [DOCUMENT ...]   writes what is printed now into the documents
//
// In fenced blocks, what stands below a line "$ command" is what the command prints. Blocks marked sh, and
// indented lines that begin with tremula, are run too and must succeed; blocks marked lsys must grow. Each
// document has a folder of its own with the files that the examples speak of. Pictures are drawn small, and of films two
// frames. Numbers are compared to the digits
// they are printed with; those that no two runs share (seconds, bytes, residuals at rounding) are not. In tables of
// benchmarks these are the columns that are named so.
import { execFileSync, spawnSync } from 'node:child_process';
import { copyFileSync, cpSync, existsSync, mkdtempSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, relative, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '..');
const words = process.argv.slice(2);
const refresh = words[0] === '--refresh';
if (refresh) words.shift();
if (words.length === 0) {
  console.error('usage: run_docs.mjs [--refresh] BUILD [DOCUMENT ...]');
  process.exit(2);
}
const build = resolve(words[0]);
const documents = words.length > 1 ? words.slice(1) : ['README.md', ...readdirSync(join(root, 'docs/guide'))
  .filter((name) => name.endsWith('.md')).sort().map((name) => `docs/guide/${name}`)];

const problems = [];
let commandsRun = 0;
const skipped = new Set();

function shell(folder, script) {
  ++commandsRun;
  const run = spawnSync('bash', ['-c', script.replaceAll('build/developer', build)], {
    cwd: folder, encoding: 'utf8', maxBuffer: 1 << 26, timeout: 300e3,
    env: { ...process.env, LC_ALL: 'C', PATH: `${join(build, 'bin')}:${process.env.PATH}` },
    stdio: ['ignore', 'pipe', 'pipe'] });
  return { code: run.status ?? 1, out: run.stdout ?? '', err: run.stderr ?? String(run.error) };
}

// What the examples take for granted: a tree, a scan, a sheet, a measured wind, a grammar of one's own, a scene of fields and weather.
function prepare(folder) {
  const growing = readFileSync(join(root, 'docs/guide/growing.md'), 'utf8');
  const rowan = [...growing.matchAll(/```lsys\n([^]*?)```/g)].find((match) => match[1].includes('nodes ='));
  writeFileSync(join(folder, 'my_plant.lsys'), rowan[1]);
  writeFileSync(join(folder, 'squall.csv'), 'time_s,speed_m_s\n0,2\n3,2\n4.5,14\n9,3\n');
  for (const name of ['sign.toml', 'sheet.toml']) copyFileSync(join(root, 'examples/sheets/sign.toml'), join(folder, name));
  cpSync(join(root, 'scenes'), join(folder, 'scenes'), { recursive: true });
  cpSync(join(root, 'scenes/sources'), join(folder, 'sources'), { recursive: true });
  copyFileSync(join(root, 'scenes/stam-figure-4.toml'), join(folder, 'scene.toml'));
  writeFileSync(join(folder, 'field.toml'), '[[grass]]\nspecies = "lawn"\nlow = [0, 0]\nhigh = [0.3, 0.3]\n' +
    '[[volumes]]\nspecies = "rice"\nlow = [1, 0]\nhigh = [2, 1]\ntexel_size = 0.04\n' +
    '[[impressions]]\nname = "far"\n' +
    ['snow', 'leaves'].map((kind) => `[[drift]]\nkind = "${kind}"\nlow = [-3, -3, 0]\nhigh = [3, 3, 4]\n`).join(''));
  const made = shell(folder, `set -e
    tremula grow sapling -o tree.swc
    tremula grow stam-62 -o scan.swc
    for name in scan.mat tree.txt forest.txt; do cp scan.swc $name; done  # known by what stands in them
    tremula wind --points 11x11 --size 20x20 --period 60 -o measured.bts
    cp measured.bts field.bts`);
  if (made.code !== 0) throw new Error(`the files for the examples could not be made: ${made.err}`);
}

// Tools that not every machine has, and programs that only some builds make.
function missing(command) {
  for (const tool of ['jq']) {
    if (new RegExp(`\\b${tool}\\b`).test(command) && spawnSync('which', [tool]).status !== 0) return tool;
  }
  const program = command.match(/^build\/developer\/(\S+)/);
  return program && !existsSync(join(build, program[1])) ? program[1] : null;
}

// A drawing that takes minutes, as one that takes a second.
function quick(command) {
  if (/\.vdb\b/.test(command)) return `${command.replace(/ +#.*$/, '')} --frames 0-1`;
  if (!/^\s*tremula render/.test(command)) return command;
  const set = (text, flag, value) =>
    new RegExp(`${flag} \\S+`).test(text) ? text.replace(new RegExp(`${flag} \\S+`), `${flag} ${value}`) : `${text} ${flag} ${value}`;
  let small = set(set(command.replace(/ +#.*$/, ''), '--size', '48x28'), '--samples', '1');
  const many = /%0?\d?d|\.(mp4|webm|gif)\b/.test(command);
  if (many) small = set(small, '--frames', command.match(/--frames (\d+)-/) ? command.match(/--frames (\d+)-/)[1] : '0-1');
  return small;
}

const canTrace = () => {
  const folder = mkdtempSync(join(tmpdir(), 'tremula-docs-'));
  const run = shell(folder, 'tremula render sapling --size 2x2 --samples 1 -o a.png');
  rmSync(folder, { recursive: true, force: true });
  return run.code === 0 || !/without Embree/.test(run.err);
};
const canWriteVolumes = () => {
  const folder = mkdtempSync(join(tmpdir(), 'tremula-docs-'));
  prepare(folder);
  const run = shell(folder, 'tremula animate field.toml --object rice -o a.vdb');
  rmSync(folder, { recursive: true, force: true });
  return run.code === 0 || !/without OpenVDB/.test(run.err);
};
let tracing, volumes;

// What is left of a script where something that it needs is not there.
function possible(script) {
  if (!/tremula render|\bffmpeg\b|\.vdb\b/.test(script)) return script;
  if (/tremula render/.test(script)) tracing ??= canTrace();
  if (/\.vdb\b/.test(script)) volumes ??= canWriteVolumes();
  const ffmpeg = spawnSync('which', ['ffmpeg']).status === 0;
  return script.replaceAll(/ *\\\n\s*/g, ' ').split('\n').filter((line) => {
    if (/\.vdb\b/.test(line) && !volumes) return skipped.add('OpenVDB'), false;
    if (/tremula render/.test(line) && !tracing) return skipped.add('Embree'), false;
    if ((/^\s*ffmpeg/.test(line) || /render.*\.(mp4|webm|gif)\b/.test(line)) && !(ffmpeg && tracing)) return skipped.add('ffmpeg'), false;
    return true;
  }).map(quick).join('\n');
}

const number = /[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?/gi;
const unshared = /seconds|bytes|_s\b.*_MB|"(setup|solve|check|quality)"|residual|error_bound/;

// Of a row of a benchmark, without the columns that its table names as the machine's own. Names end a row as they end
// the table's head, for what is first in a row may be several words.
const ofTheMachine = /seconds|faster|error_bound|_(s|ms|us|MB)$/;
const isHead = (line) => /\S+\s+\S+\s+\S/.test(line) && !line.trim().split(/\s+/).some((word) => !isNaN(word));
function shared(line, head) {
  const words = line.trim().split(/\s+/), names = head.trim().split(/\s+/);
  return words.map((word, i) => (ofTheMachine.test(names[i - words.length + names.length]) ? '#' : word)).join(' ');
}

// Within a unit of the last digit printed, where another compiler may round the other way.
function agree(wanted, found) {
  const a = Number(wanted), b = Number(found);
  if (Math.abs(a) < 1e-9 && Math.abs(b) < 1e-9) return true;
  const [mantissa, exponent] = wanted.toLowerCase().split('e');
  const decimals = (mantissa.split('.')[1] ?? '').length - Number(exponent ?? 0);
  return Math.abs(a - b) <= Math.max(1e-6 * Math.abs(a), wanted.includes('.') ? 1.01 * 10 ** -decimals : 0);
}

function compare(place, command, wanted, found) {
  if (wanted.length !== found.length) {
    problems.push(`${place}: '${command}' prints ${found.length} lines, the document has ${wanted.length}` +
      (found.length ? `; the last: ${found.at(-1)}` : ''));
    return;
  }
  let head = '';
  for (let i = 0; i < wanted.length; ++i) {
    if (command.includes('bench/') && isHead(wanted[i])) head = wanted[i];
    const squeeze = (line) => line.replace(number, '#').replace(/\s+/g, ' ').trim();
    const pairs = [...shared(wanted[i], head).matchAll(number)].map((match) => match[0]);
    const others = [...shared(found[i], head).matchAll(number)].map((match) => match[0]);
    const loose = unshared.test(wanted[i]);
    if (squeeze(wanted[i]) !== squeeze(found[i]) || (!loose && !pairs.every((text, k) => agree(text, others[k])))) {
      problems.push(`${place}: '${command}' prints\n    ${found[i]}\n  the document has\n    ${wanted[i]}`);
      return;
    }
  }
}

const linesOf = (text) => (text === '' ? [] : text.replace(/\n$/, '').split('\n'));

function runTranscript(folder, place, command, wanted) {
  const lacking = missing(command);
  if (lacking) {
    skipped.add(lacking);
    return wanted;
  }
  const run = shell(folder, command);
  const found = linesOf(run.out);
  if (run.code !== 0 && !command.includes('2>&1')) problems.push(`${place}: '${command}' ends with ${run.code}: ${run.err.trim()}`);
  else if (!refresh) compare(place, command, wanted, found);
  return found;
}

function mustSucceed(folder, place, script) {
  const run = shell(folder, `set -eo pipefail; ${possible(script)}`);
  if (run.code !== 0) problems.push(`${place}: ends with ${run.code}: ${run.err.trim().split('\n').at(-1)}\n${script.trim()}`);
}

// Not for a test to run: what installs, builds or opens other programs.
const foreign = /^\s*(\.\/scripts|scripts\/|cmake|ctest|apt|sudo|git|npm|node|blender)/m;

function runDocument(document) {
  const folder = mkdtempSync(join(tmpdir(), 'tremula-docs-'));
  try {
    prepare(folder);
    const lines = readFileSync(join(root, document), 'utf8').split('\n');
    const kept = [];
    for (let i = 0; i < lines.length; ++i) {
      kept.push(lines[i]);
      const place = `${document}:${i + 1}`;
      const indented = lines[i].match(/^ {4}(tremula .*)$/);
      if (indented) mustSucceed(folder, place, indented[1]);
      const fence = lines[i].match(/^```(\w*)$/);
      if (!fence) continue;
      const end = lines.indexOf('```', i + 1);
      const block = lines.slice(i + 1, end);
      if (block.some((line) => line.startsWith('$ '))) {
        for (let k = 0; k < block.length;) {
          if (!block[k].startsWith('$ ')) {
            kept.push(block[k++]);
            continue;
          }
          let next = k + 1;
          while (next < block.length && !block[next].startsWith('$ ')) ++next;
          kept.push(block[k], ...runTranscript(folder, `${document}:${i + 2 + k}`, block[k].slice(2),
                                               block.slice(k + 1, next)));
          k = next;
        }
      } else {
        kept.push(...block);
        const text = block.join('\n');
        if (fence[1] === 'sh' && /\btremula\b/.test(text) && !foreign.test(text)) mustSucceed(folder, place, text);
        if (fence[1] === 'lsys') {
          writeFileSync(join(folder, 'example.lsys'), `${text}\n`);
          mustSucceed(folder, place, 'tremula grow example.lsys -o example.swc');
        }
      }
      kept.push('```');
      i = end;
    }
    if (refresh) writeFileSync(join(root, document), kept.join('\n'));
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

// "  tremula animate oak -o oak.html      a grown oak": the command ends where two blanks do.
function runHelp() {
  const folder = mkdtempSync(join(tmpdir(), 'tremula-docs-'));
  prepare(folder);
  const help = (command) => execFileSync(join(build, 'bin/tremula'), [...command, '--help'], { encoding: 'utf8' });
  const commands = [...help([]).matchAll(/^ {2}([a-z]+) {2,}/gm)].map((match) => match[1]);
  for (const command of [[], ...commands.map((name) => [name])]) {
    const examples = help(command).split('Examples:')[1] ?? '';
    const place = `tremula ${command.join(' ')} --help`;
    if (!examples) problems.push(`${place}: has no examples`);
    const joined = examples.replaceAll(/ *\\?\n {4,}(?=\S)/g, ' ');
    for (const [, example] of joined.matchAll(/^ {2}(tremula (?:\S+ ?)*)/gm)) {
      if (!/COMMAND/.test(example)) mustSucceed(folder, place, example);
    }
  }
  rmSync(folder, { recursive: true, force: true });
}

for (const document of documents) runDocument(document);
if (!refresh && words.length === 1) runHelp();
for (const name of skipped) console.log(`run_docs: without ${name}, the commands that need it were left out`);
for (const problem of problems) console.error(`run_docs: ${problem}`);
console.log(`run_docs: ${commandsRun} commands run, ${problems.length} problems`);
process.exit(problems.length > 0 ? 1 : 0);
