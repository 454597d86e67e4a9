// The .glb as Godot 3.2 imports and plays it without a screen, against what the file says; and the scripts of the guide.
import assert from 'node:assert/strict';
import {spawn, spawnSync} from 'node:child_process';
import {copyFileSync, cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, describe, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {openSkin} from './skin.mjs';
import {animateClips, heightOf, largestDistance, recipe, tolerance, withClips} from './support.mjs';

const godot = process.env.GODOT ?? 'godot3-server';
const missing = spawnSync(godot, ['--version']).error;

const scripts = fileURLToPath(new URL('godot', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'tremula-godot-'));
after(() => rmSync(folder, {recursive: true, force: true}));
// The editor keeps settings and caches of its own.
const env = {...process.env, HOME: folder, XDG_CONFIG_HOME: folder, XDG_DATA_HOME: folder, XDG_CACHE_HOME: folder};

// What the guide says to set in the Import dock.
const settings = `[remap]

importer="scene"
type="PackedScene"

[params]

animation/fps=30
animation/optimizer/enabled=false
`;

// A project with this file in it as plant.glb, imported.
async function importPlant(name, glb, dock = settings) {
  const project = join(folder, name);
  cpSync(scripts, project, {recursive: true});
  copyFileSync(glb, join(project, 'plant.glb'));
  if (dock) writeFileSync(join(project, 'plant.glb.import'), dock);
  const editor = spawn(godot, ['--path', project, '--editor'], {env, stdio: ['ignore', 'pipe', 'ignore']});
  const heard = await new Promise((resolve) => {
    let text = '';
    const late = setTimeout(() => resolve(text), 120_000);
    const end = () => { clearTimeout(late); resolve(text); };
    editor.stdout.on('data', (bytes) => {
      text += bytes;
      if (text.includes('imported [')) end();
    });
    editor.on('exit', end);
  });
  editor.kill('SIGKILL');  // it does not quit by itself
  assert.match(heard, /imported \[res:\/\/plant.glb\]/);
  return project;
}

function run(project, script, result) {
  spawnSync(godot, ['--path', project, '-s', script], {env, stdio: 'ignore', timeout: 120_000, killSignal: 'SIGKILL'});
  return JSON.parse(readFileSync(join(project, result), 'utf8'));
}

describe('Godot', missing ? {skip: `no ${godot} found; set GODOT`} : {}, () => {
  const clips = {'calm loop': 2, breeze: 6, 'gale loop': 16}, times = [0, 3.3333, 9.87, 17.777, 20];

  // near: what its vertices may be off by, as a part of the height.
  async function compare(t, name, options, dock, near) {
    const {glb, report} = animateClips({...withClips, clips}, options);
    const project = await importPlant(name, glb, dock);
    writeFileSync(join(project, 'times.json'),
                  JSON.stringify(Object.fromEntries(Object.keys(clips).map((clip) => [clip, times]))));
    const found = run(project, 'look.gd', 'look.json'), skin = await openSkin(glb), height = heightOf(skin.rest);
    assert.equal(found.joints, report.glb.joints);
    assert.equal(found.binds, report.glb.joints);
    assert.deepEqual(found.materials, ['bark', 'leaf']);
    assert.ok(largestDistance(found.rest, skin.rest) < 1e-5 * height);
    assert.deepEqual(Object.keys(found.clips).sort(), Object.keys(clips).sort());
    let off = 0;
    for (const [clip, {length, loop, poses}] of Object.entries(found.clips)) {
      assert.equal(length, 20, clip);
      assert.equal(loop, clip.endsWith('loop'), clip);
      poses.forEach((pose, i) => { off = Math.max(off, largestDistance(pose, skin.pose(clip, times[i]))); });
      assert.ok(largestDistance(poses[0], poses.at(-1)) < 1e-6 * height, `${clip} does not close`);
    }
    t.diagnostic(`off by ${(off / height).toExponential(2)} of the height at most; ${height.toFixed(2)} m high, ` +
                 `${found.high.toFixed(2)} by the bounds of its mesh`);
    assert.ok(off < near * height, `${off} m of ${height} m`);
    return {high: found.high, height};
  }

  test('plays every vertex of a plant in several winds as the file says', async (t) => {
    const {high, height} = await compare(t, 'floats', {compress: 'none'}, settings, 1e-5);
    assert.ok(Math.abs(high - height) < 1e-3 * height);
  });

  test('takes a quantised file, but its bounds for metres', async (t) => {
    const {high, height} = await compare(t, 'quantised', {}, settings, 1e-5);
    assert.ok(high > 1000 * height, `${high} m: the guide says otherwise`);
  });

  test('plays less well by what the import is set to at first', (t) =>
    compare(t, 'at-first', {compress: 'none'}, '', 0.01));

  describe('by the scripts of the guide', () => {
    let found, skin, height;
    before(async () => {
      const {glb} = animateClips(withClips, {compress: 'none'});
      const project = await importPlant('forest', glb);
      writeFileSync(join(project, 'forest.gd'), recipe('gdscript', 'fade_to'));
      writeFileSync(join(project, 'winds.gd'), recipe('gdscript', 'AnimationTree'));
      [found, skin] = [run(project, 'forest_look.gd', 'forest.json'), await openSkin(glb)];
      height = heightOf(skin.rest);
    });
    const apart = (a, b) => {  // angle between quaternions
      const sign = Math.sign(a.reduce((sum, x, k) => sum + x * b[k], 0));
      return 4 * Math.asin(Math.hypot(...a.map((x, k) => x - sign * b[k])) / 2);
    };
    const between = (turns, from, to, what) => {
      const whole = turns.map((_, j) => apart(from[j], to[j]));
      assert.ok(whole.reduce((a, b) => Math.max(a, b)) > 0.05, what);
      turns.forEach((turn, j) => {
        const there = apart(from[j], turn), left = apart(turn, to[j]);
        assert.ok(there + left < whole[j] + 1e-5, `${what}, joint ${j}`);
        assert.ok(Math.abs(there - left) < 1e-4, `${what} is half way, joint ${j}`);
      });
    };

    test('plays plants of one skeleton from another instant each, and fades to another wind', () => {
      assert.equal(found.plants.length, 9);
      found.plants.forEach(({at, now, first, later, before, after: faded}, i) => {
        assert.ok(Math.abs(now - 20 * i / 9) < 1e-5, `plant ${i} begins at ${now} s`);
        const off = (vertices, clip, time) => largestDistance(vertices, skin.pose(clip, time % 20), at);
        assert.ok(off(first, 'calm', now) < 1e-5 * height, `plant ${i}`);
        assert.ok(off(later, 'calm', now + 13.7) < 1e-5 * height, `plant ${i} later`);
        assert.ok(off(before, 'calm', now + 13.7) < 1e-5 * height, `plant ${i} does not jump`);
        assert.ok(off(faded, 'gale', now + 18.7) < tolerance * height, `plant ${i} in the other wind`);
      });
    });

    test('blends two winds half way in a tree', () => {
      assert.ok(largestDistance(found.winds.calm, skin.pose('calm', 5)) < 1e-5 * height);
      assert.ok(largestDistance(found.winds.gale, skin.pose('gale', 7)) < 1e-5 * height);
      between(found.winds.between, found.turns.calm, found.turns.gale, 'a wind in a tree');
    });
  });
});
