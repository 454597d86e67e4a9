// What the tests share: the program's outputs for small plants, poses from .csv, and a browser.
import {execFileSync} from 'node:child_process';
import {existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {delimiter, join, resolve} from 'node:path';
import {after} from 'node:test';
import {fileURLToPath} from 'node:url';
import {chromium} from 'playwright-core';

export const program = process.env.TREMULA_PROGRAM ?? 'tremula';
const data = process.env.TREMULA_DATA ?? fileURLToPath(new URL('../../../shared/data', import.meta.url));

const folder = mkdtempSync(join(tmpdir(), 'tremula-viewer-'));
after(() => rmSync(folder, {recursive: true, force: true}));

// A forked stem without leaves, and a second stem with a root of its own.
const forkedSwc = `1 1 0 0 0 0.012 -1
2 1 0.1 0 0.8 0.010 1
3 1 0.3 0.1 1.5 0.004 2
4 1 -0.4 0 1.4 0.005 2
5 1 -0.6 0.2 1.9 0.003 4
6 1 1 0 0 0.008 -1
7 1 1.1 0.1 1 0.004 6
`;

function smallPlants() {
  const swc = join(folder, 'forked.swc');
  writeFileSync(swc, forkedSwc);
  // Bare stems move little in the wind that a sapling in leaf wants.
  const plants = [{name: 'sapling', input: 'sapling', wind: 6}, {name: 'forked', input: swc, wind: 15}];
  const scan = join(data, 'qsm/rtwig_sapling_simpleforest.csv');
  if (existsSync(scan)) plants.push({name: 'scan', input: scan, wind: 15});
  return plants;
}
export const plants = smallPlants();

export const settings = {period: 20, fps: 10};

// A plant on bones in several winds.
export const withClips = {name: 'sapling-winds', input: 'sapling', clips: {calm: 2, breeze: 6, gale: 16}};

// Runs `tremula animate` on it: the path of the .glb and what the report says.
export function animateClips({name, input, clips}, options = {}) {
  const glb = join(folder, `${name}.glb`), report = join(folder, `${name}.json`);
  const flags = [...Object.entries(clips).map(([clip, speed]) => ['clip', `${clip}:${speed}`]), ...Object.entries(options)]
                    .flatMap(([flag, value]) => [`--${flag}`, String(value)]);
  execFileSync(program, ['animate', input, ...flags, '-o', glb, '--report', report], {stdio: ['ignore', 'ignore', 'pipe']});
  return {glb, report: JSON.parse(readFileSync(report, 'utf8'))};
}

export const guide = readFileSync(new URL('../../docs/guide/many-plants.md', import.meta.url), 'utf8');

// Its block that is in this language and has this in it.
export function recipe(language, holding) {
  const blocks = guide.split('```').filter((block) => block.startsWith(`${language}\n`));
  return blocks.find((block) => block.includes(holding)).slice(language.length + 1);
}

// Runs `tremula animate` with options over the usual ones; returns the paths of what it wrote, by extension. Poses are
// linear, as the page and engines blend shapes.
export function animate({name, input, wind}, extensions, options = {}) {
  const paths = Object.fromEntries(extensions.map((extension) => [extension, join(folder, `${name}.${extension}`)]));
  const flags = Object.entries({'wind-speed': wind, modes: 20, seed: 1, pose: 'linear', ...settings, ...options})
                    .filter(([, value]) => value !== undefined)
                    .flatMap(([flag, value]) => [value].flat().flatMap((each) => [`--${flag}`, String(each)]));
  const outputs = Object.values(paths).flatMap((path) => ['-o', path]);
  execFileSync(program, ['animate', input, ...flags, ...outputs], {stdio: ['ignore', 'ignore', 'pipe']});
  return paths;
}

// What the example of many instances writes, and what they are; nothing where the examples were not built.
export function avenue() {
  const example = join(process.env.TREMULA_EXAMPLES ?? '', 'example_06_avenue');
  if (!existsSync(example)) return undefined;
  const instances = execFileSync(example, [folder], {encoding: 'utf8'}).trim().split('\n').map((line) => {
    const [x, y, turn, scale, timeShift] = line.split(' ').map(Number);
    return {x, y, turn, scale, timeShift};
  });
  return {glb: join(folder, 'avenue.glb'), html: join(folder, 'avenue.html'), instances};
}

// What an example prints of its pages into this folder, line by line; nothing where the examples were not built.
function linesOfExample(name) {
  const example = join(process.env.TREMULA_EXAMPLES ?? '', name);
  return existsSync(example) ? execFileSync(example, [folder], {encoding: 'utf8'}).trim().split('\n') : undefined;
}
const posedOf = (numbers) => {
  const [time, index, ...place] = numbers.map(Number);
  return {time, index, place};
};

// The page of the example of a meadow, and where vertices are in it.
export function meadow() {
  const posed = linesOfExample('example_08_meadow_page')?.map((line) => posedOf(line.split(' ')));
  return posed && {html: join(folder, 'meadow.html'), posed};
}

// The pages of an example that writes several, the same by kind.
function pagesOfExample(name) {
  const lines = linesOfExample(name)?.map((line) => line.split(' '));
  return lines && [...new Set(lines.map(([kind]) => kind))].map((kind) => ({
    kind, html: join(folder, `${kind}.html`),
    posed: lines.filter(([of]) => of === kind).map(([, ...numbers]) => posedOf(numbers)),
  }));
}

export const drifts = () => pagesOfExample('example_09_drift_page');
export const paintedTrees = () => pagesOfExample('example_10_painted_trees_page');
export const volumes = () => pagesOfExample('example_11_volume_page');

// The page of a field of a scene, and the report of `tremula animate`.
export const animateField = (species) => animateThing(species, `[[grass]]
name = "field"
species = "${species}"
low = [-0.8, -0.8]
high = [0.8, 0.8]
`);

export const animateDrift = (kind) => animateThing(kind, `[[drift]]
name = "field"
kind = "${kind}"
low = [-3, -3, 0]
high = [3, 3, 4]
density = 4
lie_time = 1
`);

export const animateImpressions = (shape) => animateThing(shape, `[[impressions]]
name = "field"
shape = "${shape}"
height = 12
[[impressions.grid]]
columns = 2
rows = 2
spacing = [14, 14]
`);

export const animateVolume = (species, half) => animateThing(species, `[[volumes]]
name = "field"
species = "${species}"
low = [-${half}, -${half}]
high = [${half}, ${half}]
`);

function animateThing(name, thing) {
  const scene = join(folder, `${name}.toml`), html = join(folder, `${name}-field.html`), report = join(folder, `${name}.json`);
  writeFileSync(scene, `[motion]
period = 6
fps = 20
[wind]
wind_speed = 6
${thing}`);
  execFileSync(program, ['animate', scene, '--object', 'field', '-o', html, '--report', report], {stdio: ['ignore', 'ignore', 'pipe']});
  return {html, report: JSON.parse(readFileSync(report, 'utf8'))};
}

// Poses by frame: [{time, nodes: [[x, y, z], …], turns: [rotation vector, …]}, …].
export const readPoses = (path) => parsePoses(readFileSync(path, 'utf8'));
export function parsePoses(table) {
  const poses = [];
  const [header, ...lines] = table.split('\n').filter((line) => line && !line.startsWith('#'));
  const column = Object.fromEntries(header.split(',').map((name, i) => [name, i]));
  for (const line of lines) {
    const values = line.split(',').map(Number);
    const pose = (poses[values[column.frame]] ??= {time: values[column.time_s], nodes: [], turns: []});
    pose.nodes[values[column.node]] = [values[column.x], values[column.y], values[column.z]];
    pose.turns[values[column.node]] = [values[column.rx], values[column.ry], values[column.rz]];
  }
  return poses;
}

export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

export function largestDistance(found, wanted, shift = [0, 0, 0]) {
  if (found.length !== wanted.length) throw new Error(`${found.length} vertices, wanted ${wanted.length}`);
  return found.reduce((most, at, i) => Math.max(most, distance(at, wanted[i].map((x, k) => x + shift[k]))), 0);
}

// Where the nodes are without wind.
export function restNodes(plant) {
  const {csv} = animate({...plant, name: `${plant.name}-rest`}, ['csv'], {'wind-speed': 0, frames: 0});
  return readPoses(csv)[0].nodes;
}

export function heightOf(points) {
  const heights = points.map(([, , z]) => z);
  return heights.reduce((a, b) => Math.max(a, b)) - heights.reduce((a, b) => Math.min(a, b));
}

// What positions in 16 bits and the targets over them may be off by, as a part of the height.
export const tolerance = 1e-4;

// Pairs of vertices and nodes that are in the same place at rest: the tips of the axes. The branch that carries such
// a vertex ends at the node.
export function tips(vertices, nodes) {
  const near = 0.5 * tolerance * heightOf(nodes);
  const roots = nodes.length - (Math.max(...vertices.map(({branch}) => branch)) + 1);
  return vertices.filter(({along, branch, rest}) => along === 1 && distance(rest, nodes[roots + branch]) < near)
      .map(({index, branch}) => ({index, node: roots + branch}));
}

// The largest distance between vertices and their nodes, as a part of the height; and what moved most.
export function largestError(pairs, positions, pose, rest) {
  const largest = Math.max(...pose.nodes.map((node, i) => distance(node, rest[i])));
  if (largest < 20 * tolerance * heightOf(rest)) throw new Error('hardly anything moves: this would show nothing');
  return Math.max(...pairs.map(({node}, i) => distance(positions[i], pose.nodes[node]))) / heightOf(rest);
}

function findBrowser() {
  const names = ['chromium', 'chromium-browser', 'google-chrome', 'chrome'];
  const candidates = process.env.PATH.split(delimiter).flatMap((place) => names.map((name) => join(place, name)));
  return process.env.CHROMIUM ?? candidates.find((path) => existsSync(path));
}
export const browserPath = findBrowser();
export const needsBrowser = browserPath ? {} : {skip: 'no Chromium found; set CHROMIUM'};

export function launchBrowser() {
  return chromium.launch({
    executablePath: browserPath,
    // WebGL without a graphics card; and no calls home.
    args: ['--no-sandbox', '--disable-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
           '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
  });
}

// A page that collects what went wrong in it and what it asked for.
export async function openPage(browser, options) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(120_000);  // pictures without a graphics card take their time
  const complaints = [], requests = [];
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('request', (request) => requests.push(request.url()));
  return {page, complaints, requests};
}

export function screenshotPath(name) {
  const place = resolve(process.env.TREMULA_SCREENSHOTS ?? join(tmpdir(), 'viewer-screenshots'));
  mkdirSync(place, {recursive: true});
  return join(place, `${name}.png`);
}
